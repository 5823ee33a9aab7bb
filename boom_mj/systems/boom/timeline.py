"""What happens in a boom's recording: joint angles; hold, start, slew, move, reversal, after motion or release."""

import numpy as np

from boom_mj.recording import Recording, sample
from boom_mj.sensors import driving_angles
from boom_mj.systems.system import Timeline

Array = np.ndarray
DRIVE = "joint/position"
PHASES = ("hold", "start", "move", "slew", "reversal", "after motion", "after release")
MOVING = 1e-3  # rad/s
SHORT_S = 1.0  # of a start and around a reversal
AFTER_S = 12.0  # how long a stop is remembered
DROP_N = 1.0  # change of the known load between blocks that is a release


def timeline(log: Recording, joint_noise: float, block_s: float) -> Timeline:
    """Of a recording whose joint sensors have some noise, rad."""
    joints = log[DRIVE]
    start, duration = joints.time[0], float(joints.time[-1] - joints.time[0])

    def coordinates(time: Array) -> Array:
        return np.stack([np.interp(time, joints.time - start, column) for column in joints.values.T], axis=1)

    return Timeline(start, duration, coordinates, lambda: _phases(log, start, duration, joint_noise, block_s))


def _phases(log: Recording, start: float, duration: float, joint_noise: float, block: float) -> Array:
    time = np.arange(0, duration + block, block) + block / 2
    angles = driving_angles(log, joint_noise, time + start)
    rate = np.gradient(angles, block, axis=0)
    moving = np.abs(rate) > MOVING
    names = np.full(len(time), "hold", dtype="<U14")
    load = sample(log["load"], time + start) if "load" in log else np.zeros((len(time), 3))
    dropped = np.flatnonzero(np.linalg.norm(np.diff(load, axis=0), axis=1) > DROP_N)
    if dropped.size:
        names[dropped[0] :] = "after release"
    any_moving = moving.any(axis=1)
    for stop in np.flatnonzero(any_moving[:-1] & ~any_moving[1:]):
        names[stop : stop + int(AFTER_S / block)] = "after motion"
    names[any_moving] = np.where(moving[any_moving, 0], "slew", "move")
    for begin in np.flatnonzero(~any_moving[:-1] & any_moving[1:]):
        names[begin : begin + int(SHORT_S / block)] = "start"
    for turn in np.flatnonzero((rate[:-1] * rate[1:] < 0).any(axis=1) & any_moving[1:]):
        names[max(0, turn - int(SHORT_S / block / 2)) : turn + int(SHORT_S / block / 2)] = "reversal"
    return names
