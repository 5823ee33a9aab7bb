"""Replay: the joint angles and the known load of a log drive the model."""

import time as clock
from dataclasses import dataclass

import numpy as np

from boom_mj.recording import Recording, named_signal
from boom_mj.replay.comparison import Group, compare
from boom_mj.sensors import check_drivable, driving_angles, ideal_signals, noise_levels, sample
from boom_mj.simulation import Plant, Trajectory, run, step_times


@dataclass(frozen=True)
class Replay:
    """A log, its simulated recording at the log's own times, and the comparison."""

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
    angles = driving_angles(log, noise["joint/position"][0], steps + start, plant.effects)
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
