"""Where effects may be in an MJCF machine, and what sizes are typical there."""

from collections.abc import Iterator, Sequence

import mujoco
import numpy as np

from boom_mj.effects import Site
from boom_mj.effects.spec_edits import BRAKE
from boom_mj.engine import mass_matrix
from boom_mj.recording import Recording
from boom_mj.systems.mjcf.channel_map import ChannelMap
from boom_mj.systems.mjcf.readout import joint_moved
from boom_mj.systems.mjcf.rollout import Run, joint_of

Array = np.ndarray
TINY = 1e-9


def sites_of(
    spec: mujoco.MjSpec, channels: ChannelMap, logs: Sequence[Recording], runs: Sequence[Run]
) -> tuple[Site, ...]:
    """Joints, flexible links, bodies, actuators, channels, and the machine as a whole.

    Args:
        logs: to learn from, with the nominal run of each.
    """
    heavy = bool(np.any(np.asarray(spec.option.gravity)))
    return (
        *_joints(spec, channels, logs, runs),
        *(_site("elastic", link=name) for name in sorted(links(spec))),
        *_bodies(spec),
        *_actuators(spec, channels, logs),
        *_channels(spec, channels, logs),
        _site(*(("heavy",) if heavy else ())),
    )


def links(spec: mujoco.MjSpec) -> set[str]:
    """Flexible links: names LINK of chains of joints LINK/1, LINK/2, ..."""
    return {joint.name.partition("/")[0] for joint in spec.joints if joint.name.endswith("/1")}


def _site(*tags: str, **location: str) -> Site:
    return Site(tuple(location.items()), frozenset({"mjcf", *tags}))


def _joints(
    spec: mujoco.MjSpec, channels: ChannelMap, logs: Sequence[Recording], runs: Sequence[Run]
) -> Iterator[Site]:
    model = spec.copy().compile()
    mass = mass_matrix(model)
    measured = {e.joint for e in channels.channel if e.joint and e.what == "position"}
    actuated = {joint_of(spec, e.actuator) for e in channels.channel if e.actuator} | set(channels.driven)
    for name in runs[0].position:
        if name.partition("/")[0] in links(spec):
            continue
        joint = model.joint(name)
        dof = int(joint.dofadr[0])
        inertia = float(mass[dof, dof])
        stiffness, damping = float(model.jnt_stiffness[joint.id]), float(np.ravel(model.dof_damping[dof])[0])
        position, speed = _motion(channels, name, logs, runs)
        span = max(float(np.ptp(position)), TINY)
        forces = [inertia * _rms(np.concatenate([run.acceleration[name] for run in runs])), stiffness * span / 4]
        forces += [
            abs(model.actuator(e.actuator).gear[0]) * _rms(_logged(e.name, logs))
            for e in channels.role("compare")
            if e.actuator and joint_of(spec, e.actuator) == name
        ]
        forces += [
            _rms(np.concatenate([run.force[e.actuator] for run in runs]))
            for e in channels.role("control")
            if joint_of(spec, e.actuator) == name
        ]
        said = {
            "driven": name in channels.driven,
            "free": name not in channels.driven,
            "measured": name in measured,
            "actuated": name in actuated,
            "sprung": bool(stiffness),
            "rubbing": bool(model.dof_frictionloss[dof]),
            "temperature": channels.temperature(name) is not None,
            "outermost": model.body_jntnum[_behind(model, int(joint.bodyid[0]))].sum() == 1,
        }
        yield Site(
            (("joint", name),),
            frozenset({"mjcf", *(tag for tag, so in said.items() if so)}),
            unit="m" if joint.type[0] == int(mujoco.mjtJoint.mjJNT_SLIDE) else "rad",
            value=max(*forces, TINY),
            span=span,
            speed=max(_rms(speed), TINY),
            inertia=inertia,
            damping=damping,
            stiffness=stiffness,
            armature=float(model.dof_armature[dof]),
            friction=_friction(model, name),
        )


def _friction(model: mujoco.MjModel, joint: str) -> float:
    """Dry friction of a joint, that behind its play too."""
    loss = float(model.dof_frictionloss[model.joint(joint).dofadr[0]])
    brakes = [k for k in range(model.ntendon) if model.tendon(k).name == f"{joint}/{BRAKE}"]
    return loss + sum(float(np.ravel(model.tendon_stiffness[k])[0] * model.tendon_springyield[k]) for k in brakes)


def _behind(model: mujoco.MjModel, body: int) -> list[int]:
    """A body and all that it carries."""
    found = [body]
    for child in range(body + 1, model.nbody):
        found += [child] if int(model.body_parentid[child]) in found else []
    return found


def _motion(channels: ChannelMap, joint: str, logs: Sequence[Recording], runs: Sequence[Run]) -> tuple[Array, Array]:
    """Measured position and speed of a joint where there are any, else simulated ones."""
    names = [e.name for e in channels.role("drive") if e.joint == joint]
    names += [f"motion/{joint}"] if f"motion/{joint}" in logs[0] else []
    if not names:
        return np.concatenate([run.position[joint] for run in runs]), np.concatenate(
            [run.velocity[joint] for run in runs]
        )
    signals = [log[names[0]] for log in logs]
    speeds = [np.gradient(s.values[:, 0], s.time) for s in signals]
    return np.concatenate([s.values[:, 0] for s in signals]), np.concatenate(speeds)


def _bodies(spec: mujoco.MjSpec) -> Iterator[Site]:
    model, flexible = spec.copy().compile(), links(spec)
    for k in range(1, model.nbody):
        if model.body_weldid[k] != 0 and model.body_mass[k] > 0:
            leaf = not np.any(model.body_parentid[k + 1 :] == k)
            inner = model.body_jntnum[k] and model.joint(model.body_jntadr[k]).name.partition("/")[0] in flexible
            tags = {"mjcf", *(("leaf",) if leaf else ()), *(() if inner else ("whole",))}
            yield Site((("body", model.body(k).name),), frozenset(tags), unit="kg", mass=float(model.body_mass[k]))


def _actuators(spec: mujoco.MjSpec, channels: ChannelMap, logs: Sequence[Recording]) -> Iterator[Site]:
    for entry in channels.channel:
        judged = entry.role == "compare" and joint_of(spec, entry.actuator) in channels.driven
        if entry.actuator and (entry.role == "control" or judged):
            size = max(_rms(_logged(entry.name, logs)), TINY)
            key = (("actuator", entry.actuator),)
            yield Site(key, frozenset({"mjcf"}), unit=entry.unit or "1", value=size, step=_step(entry.name, logs))


def _channels(spec: mujoco.MjSpec, channels: ChannelMap, logs: Sequence[Recording]) -> Iterator[Site]:
    for entry in channels.channel:
        if entry.sensed:
            values = _logged(entry.name, logs)
            tags = {"mjcf", "compared" if entry.role == "compare" else "driving"}
            tags |= set() if entry.actuator else {"motion"}
            tags |= {"temperature"} if channels.temperature(joint_moved(spec, entry)) else set()
            size = max(float(np.std(values[np.isfinite(values)])), TINY)
            key = (("channel", entry.name),)
            yield Site(key, frozenset(tags), unit=entry.unit or "1", value=size, step=_step(entry.name, logs))


def _logged(name: str, logs: Sequence[Recording]) -> Array:
    return np.concatenate([log[name].values[:, 0] for log in logs])


def _step(name: str, logs: Sequence[Recording]) -> float:
    return float(np.median(np.diff(logs[0][name].time)))


def _rms(values: Array) -> float:
    return float(np.sqrt(np.nanmean(np.square(values))))
