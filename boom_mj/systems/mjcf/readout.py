"""What goes into a stretch of a log's simulation, and what its run says in the channels of the map."""

from collections.abc import Callable
from dataclasses import replace

import mujoco
import numpy as np

from boom_mj.effects import Effect, ForceEffect, InputEffect
from boom_mj.recording import Recording
from boom_mj.systems.fidelity import Level
from boom_mj.systems.mjcf.channel_map import ChannelEntry, ChannelMap
from boom_mj.systems.mjcf.pushing import Push, exertion
from boom_mj.systems.mjcf.rollout import Inputs, Run, joint_of
from boom_mj.systems.mjcf.segments import SHAKEN, UNSURE

Array = np.ndarray
Hypothesis = tuple[Effect, ...]
MEASURED = Level(1.0)
MOTIONS = "measured", "nominal", "simulated"  # that an effect may see


def inputs_of(
    spec: mujoco.MjSpec,
    channels: ChannelMap,
    hypothesis: Hypothesis,
    log: Recording,
    begin: float,
    time: Array,
    nominal: Callable[[], Run],
    level: Level = MEASURED,
) -> Inputs:
    """What drives a stretch that begins at a log's time, at the steps of the simulation, under effects.

    Args:
        nominal: the stretch without effects.
        level: what measured motion and the state at the start are like; its step is that of `time`.
    """
    path, command, force, reaction, prefix = {}, {}, {}, {}, SHAKEN * level.shaken
    for entry in channels.role("drive"):
        values = log[prefix + entry.name].values[:, 0]
        clock = log[entry.name].time - begin
        for effect in _at(hypothesis, "channel", entry.name):
            values = effect.invert(clock, values)
        path[entry.joint] = _spline(clock, values, time)
    for entry in channels.role("control"):
        clock = log[entry.name].time - begin
        values = np.interp(time, clock, log[entry.name].values[:, 0])
        for effect in _at(hypothesis, "actuator", entry.actuator):
            values = effect.apply(time, values)
        command[entry.actuator] = values
    for joint in pushed(hypothesis, channels):
        motors = [(exertion(spec, a), command[a]) for a in command if joint_of(spec, a) == joint]
        push = Push(joint, _forces(hypothesis, joint), tuple(motors), temperature(channels, joint, log, time))
        by = {sees: replace(push, effects=[e for e in push.effects if e.sees == sees]) for sees in MOTIONS}
        force[joint] = np.zeros(len(time))
        if by["measured"].effects:
            motion = log[f"{prefix}motion/{joint}"]
            position = _spline(motion.time - begin, motion.values[:, 0], time)
            force[joint] += by["measured"](time, position, np.gradient(position, time))
        if by["nominal"].effects:
            run = nominal()
            force[joint] += by["nominal"](time, run.position[joint], run.velocity[joint])
        if by["simulated"].effects:
            reaction[joint] = by["simulated"]
    start = {joint: log[f"start/{joint}"].values[0] for joint in channels.started if f"start/{joint}" in log}
    number, which = divmod(level.start - 1, 2)
    if level.start and (joint := channels.started[number]) in start:
        start[joint] = start[joint] + log[UNSURE + joint].values[0] * np.eye(2)[which]
    return Inputs(time, path, command, force, start, reaction)


def said(
    entry: ChannelEntry,
    run: Run,
    model: mujoco.MjModel,
    spec: mujoco.MjSpec,
    channels: ChannelMap,
    effects: Hypothesis,
    log: Recording,
) -> Array:
    """What a run says in a compared channel, (n,), before the channel's own effects."""
    if entry.sensor:
        sensor = model.sensor(entry.sensor)
        return run.sensordata[:, sensor.adr[0] + entry.component]
    if entry.joint:
        return (run.position if entry.what == "position" else run.velocity)[entry.joint]
    joint = joint_of(spec, entry.actuator)
    if joint not in channels.driven:
        return run.force[entry.actuator]
    force, warm = run.force[joint], temperature(channels, joint, log, run.time)
    for effect in _forces(effects, joint):
        force = force - Push(joint, (effect,), (), warm)(run.time, run.position[joint], run.velocity[joint], force)
    for motor in reversed(_at(effects, "actuator", entry.actuator)):
        force = motor.invert(run.time, force)
    return force


def joint_moved(spec: mujoco.MjSpec, entry: ChannelEntry) -> str:
    """The joint that a channel belongs to, "" if to none."""
    return joint_of(spec, entry.actuator) if entry.actuator else entry.joint


def temperature(channels: ChannelMap, joint: str, log: Recording, time: Array) -> Array | None:
    """Of a joint, (n,), at times from a stretch's beginning; None where none is logged."""
    entry = channels.temperature(joint)
    if entry is None:
        return None
    own = log[entry.name]
    return np.interp(time, own.time - log["start"].time[0], own.values[:, 0])


def pushed(hypothesis: Hypothesis, channels: ChannelMap) -> tuple[str, ...]:
    """Joints that effects push: those that are not driven."""
    joints = {str(e.location["joint"]) for e in hypothesis if isinstance(e, ForceEffect)}
    return tuple(sorted(joints - set(channels.driven)))


def in_loop(hypothesis: Hypothesis, channels: ChannelMap) -> bool:
    """Whether an effect pushes a joint that is not driven by what the simulation does."""
    hands = pushed(hypothesis, channels)
    return any(
        isinstance(e, ForceEffect) and e.sees == "simulated" and e.location["joint"] in hands for e in hypothesis
    )


def _at(hypothesis: Hypothesis, key: str, name: str) -> list[InputEffect]:
    return [e for e in hypothesis if isinstance(e, InputEffect) and e.location.get(key) == name]


def _forces(hypothesis: Hypothesis, joint: str) -> list[ForceEffect]:
    return [e for e in hypothesis if isinstance(e, ForceEffect) and e.location.get("joint") == joint]


def _spline(time: Array, values: Array, at: Array) -> Array:
    """Smooth values between samples, and up to a step beyond: a cubic spline, whose second derivative does not jump."""
    from scipy.interpolate import CubicSpline

    return CubicSpline(time, values)(at)
