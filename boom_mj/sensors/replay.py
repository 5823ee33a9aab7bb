"""Replay: the joint angles and the known load of a log drive the model; its twin is compared channel by channel."""

import time as clock
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import make_interp_spline

from boom_mj.errors import LogError
from boom_mj.recording import Recording, named_signal
from boom_mj.sensors.measure import ideal_signals, noise_levels, sample, true_angles
from boom_mj.simulation import Plant, Trajectory, run, smooth_angles, step_times

Array = np.ndarray


@dataclass(frozen=True)
class Group:
    """How far twin and log are apart in one channel group.

    Attributes:
        name: sensor and direction: imu/link5 accelerometer y, markers link4 z, cylinder3, ...
        rms: of measured - simulated, in `unit`.
        noise: standard deviation of the sensor.
        ratio: rms / noise.
    """

    name: str
    unit: str
    rms: float
    noise: float

    @property
    def ratio(self) -> float:
        """rms / noise."""
        return self.rms / self.noise if self.noise else float("inf")


@dataclass(frozen=True)
class Replay:
    """A log, its simulated twin at the log's own times, and the comparison."""

    log: Recording
    twin: Recording
    trajectory: Trajectory
    groups: tuple[Group, ...]
    loop_wall_s: float


def replay(plant: Plant, log: Recording) -> Replay:
    """Drive the model with a log.

    Raises:
        LogError: the log has no joint angles, too few of them, or holes in them.
    """
    check_drivable(log)
    joints = log["joint/position"]
    start, noise = joints.time[0], noise_levels(plant.machine)
    steps = step_times(plant, joints.time[-1] - start)
    angles = true_angles(plant.effects, driving_angles(log, noise["joint/position"][0], steps + start))
    force = sample(log["load"], steps + start) if "load" in log else np.zeros((len(steps), 3))
    began = clock.perf_counter()
    trajectory = run(plant, angles, force)
    wall = clock.perf_counter() - began

    ideal = ideal_signals(trajectory)
    twin = {
        name: named_signal(name, signal.time, sample(ideal[name], signal.time - start))
        for name, signal in log.signals.items()
        if name in ideal
    }
    recording = Recording(log.name, plant.machine.name, f"simulated twin: {log.description}", twin)
    return Replay(log, recording, trajectory, compare(log, recording, noise), wall)


def check_drivable(log: Recording) -> None:
    """Raises LogError where the joint angles of a log cannot drive a model: too few, or holes in them."""
    joints = log["joint/position"]
    holes = ~np.isfinite(joints.values)
    if len(joints.time) < 20 or holes.any():
        row, column = np.argwhere(holes)[0] if holes.any() else (0, 0)
        what = f"{joints.channels[column]} is not a number at {joints.time[row]:.3f} s" if holes.any() else "too short"
        raise LogError(f"log {log.name!r}: the joint angles cannot drive the model: {what}")


def driving_angles(log: Recording, noise: float, at: Array) -> Array:
    """Smooth joint angles of a log at new times, (m, 5), rad.

    Where the log tells the commanded angles, only what the sensors read beyond them is smoothed: a drive that follows
    leaves a constant there, one that lags leaves its lag.

    Args:
        noise: standard deviation of the angle sensors, rad.
        at: times wanted, (m,), s; beyond the samples the ends are held.
    """
    joints = log["joint/position"]
    if "joint_command/position" not in log:
        return smooth_angles(joints.time, joints.values, noise, at)
    command = log["joint_command/position"]
    reference = make_interp_spline(command.time, command.values, k=5)
    within = np.clip(at, command.time[0], command.time[-1])
    beyond = joints.values - reference(np.clip(joints.time, command.time[0], command.time[-1]))
    return reference(within) + smooth_angles(joints.time, beyond, noise, at)


def compare(log: Recording, twin: Recording, noise: dict[str, Array]) -> tuple[Group, ...]:
    """Root mean square of log - twin in every channel group, against the sensor's noise."""
    groups = []
    for name, level in noise.items():
        if name not in log or name not in twin or name == "joint/position":
            continue
        signal = log[name]
        difference = signal.values - twin[name].values
        for group, columns in _groups(name, signal.channels).items():
            part = difference[:, columns]
            rms = float(np.sqrt(np.nanmean(part**2))) if np.isfinite(part).any() else float("nan")
            groups.append(Group(group, signal.unit, rms, float(level[columns[0]])))
    return tuple(groups)


def _groups(name: str, channels: tuple[str, ...]) -> dict[str, list[int]]:
    """Channel groups of a signal: name to columns."""
    if name == "markers":
        found: dict[str, list[int]] = {}
        for column, channel in enumerate(channels):
            number, axis = int(channel[len("marker") : channel.index("/")]), channel[-1]
            found.setdefault(f"markers/link{2 + (number - 1) // 3}/{axis}", []).append(column)
        return found
    stem = "cylinder" if name.startswith("cylinder") else name
    return {(channel if stem == "cylinder" else f"{name}/{channel}"): [k] for k, channel in enumerate(channels)}
