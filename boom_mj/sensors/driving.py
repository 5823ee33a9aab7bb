"""The joint angles of a log, made smooth: what drives a model."""

from collections.abc import Sequence

import numpy as np
from scipy.interpolate import make_interp_spline

from boom_mj.effects import Effect
from boom_mj.errors import LogError
from boom_mj.recording import Recording
from boom_mj.recording.names import JOINTS
from boom_mj.sensors.measure import true_angles
from boom_mj.simulation import smooth_angles

Array = np.ndarray


def check_drivable(log: Recording) -> None:
    """Raises LogError where the joint angles of a log cannot drive a model: too few, or holes in them."""
    joints = log["joint/position"]
    holes = ~np.isfinite(joints.values)
    if len(joints.time) < 20 or holes.any():
        row, column = np.argwhere(holes)[0] if holes.any() else (0, 0)
        what = f"{joints.channels[column]} is not a number at {joints.time[row]:.3f} s" if holes.any() else "too short"
        raise LogError(f"log {log.name!r}: the joint angles cannot drive the model: {what}")


def driving_angles(
    log: Recording, noise: float, at: Array, effects: Sequence[Effect] = (), joints: Sequence[int] = range(len(JOINTS))
) -> Array:
    """Smooth joint angles of a log at new times, (m, len(joints)), rad.

    Where the log tells the commanded angles, only what the sensors read beyond them is smoothed: a drive that follows
    leaves a constant there, one that lags leaves its lag.

    Args:
        noise: standard deviation of the angle sensors, rad.
        at: times wanted, (m,), s; beyond the samples the ends are held.
        effects: whose errors of the sensors are taken out before, lest they be blunted with the noise.
        joints: columns of the reading that are wanted.
    """
    reading, columns = log["joint/position"], [*joints]
    angles = true_angles(effects, reading.values)[:, columns]
    if "joint_command/position" not in log:
        return smooth_angles(reading.time, angles, noise, at)
    command = log["joint_command/position"]
    reference = make_interp_spline(command.time, command.values[:, columns], k=5)
    within = np.clip(at, command.time[0], command.time[-1])
    beyond = angles - reference(np.clip(reading.time, command.time[0], command.time[-1]))
    return reference(within) + smooth_angles(reading.time, beyond, noise, at)
