"""Recordings as means over BLOCK seconds, all channels on one grid of times.

The boom's first modes lie far below 1 / BLOCK, the noise falls, and what no model knows - the first milliseconds after
a rope is cut - weighs less.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from boom_mj.errors import LogError
from boom_mj.machine import Machine
from boom_mj.recording import Recording, Signal
from boom_mj.sensors.driving import check_drivable
from boom_mj.sensors.measure import noise_levels, sample

Array = np.ndarray
BLOCK = 0.1  # s


@dataclass(frozen=True)
class Column:
    """One channel: where it lies in a recording, and its group, such as "markers/link4/z"."""

    signal: str
    index: int
    group: str
    unit: str


@dataclass(frozen=True, eq=False)
class Blocks:
    """A recording's noisy signals but the joint angles, in means over blocks.

    Attributes:
        log: the recording.
        columns: k channels.
        time: middles of the blocks, (n,), s from the first joint angle.
        mean: (n, k); NaN where a channel has no sample.
        noise: standard deviation of the means, (n, k).
    """

    log: Recording
    columns: tuple[Column, ...]
    time: Array
    mean: Array
    noise: Array

    @property
    def start(self) -> float:
        """Stamp of the first joint angle, s."""
        return float(self.log["joint/position"].time[0])

    def of(self, signals: Mapping[str, Signal]) -> Array:
        """Means of densely sampled signals over the samples that the recording has, (n, k); their time starts at 0."""
        parts = []
        for name in dict.fromkeys(column.signal for column in self.columns):
            log = self.log[name]
            values = sample(signals[name], log.time - self.start)
            parts.append(
                _means(log.time - self.start, np.where(np.isnan(log.values), np.nan, values), len(self.time))[0]
            )
        return np.hstack(parts)


def blocks_of(machine: Machine, log: Recording) -> Blocks:
    """Block means of a recording, with the noise that the machine file tells, or its own where that is larger.

    Raises:
        LogError: the joint angles cannot drive a model, or there is nothing else.
    """
    check_drivable(log)
    joints = log["joint/position"]
    duration = joints.time[-1] - joints.time[0]
    rows = int(np.floor(duration / BLOCK + 1e-6)) + 1
    columns, means, noises = [], [], []
    for name, level in noise_levels(machine).items():
        if name not in log or name == "joint/position":
            continue
        signal = log[name]
        mean, count = _means(signal.time - joints.time[0], signal.values, rows)
        own = np.array([own_noise(values) for values in signal.values.T]) / 1.3  # its estimate scatters
        means.append(mean)
        noises.append(np.maximum(level, own) / np.sqrt(np.maximum(count, 1)))
        columns += [Column(name, k, group_of(name, signal, k), signal.unit) for k in range(mean.shape[1])]
    if not any(np.isfinite(mean).any() for mean in means):
        raise LogError(f"log {log.name!r} has nothing to compare with a model but its joint angles")
    time = (np.arange(rows) + 0.5) * BLOCK
    return Blocks(log, tuple(columns), time, np.hstack(means), np.hstack(noises))


def _means(time: Array, values: Array, rows: int) -> tuple[Array, Array]:
    """Means over the first `rows` blocks, NaN where nothing was sampled, and samples of each, (rows, k) both."""
    block = np.floor(time / BLOCK + 1e-6)
    inside = (block >= 0) & (block < rows)
    mean, count = np.full((rows, values.shape[1]), np.nan), np.zeros((rows, values.shape[1]))
    if inside.any():
        middle, samples, means = block_means(time[inside], values[inside])
        block = np.round(middle / BLOCK - 0.5).astype(int)
        mean[block], count[block] = means, samples
    return mean, count


def block_numbers(time: Array, length: float = BLOCK) -> Array:
    """Number of the stretch of `length` seconds in which each time lies, (m,) of int."""
    return np.floor(time / length + 1e-6).astype(int)


def block_means(time: Array, values: Array, length: float = BLOCK) -> tuple[Array, Array, Array]:
    """Means over stretches of `length` seconds that leave out NaN.

    Args:
        time: (m,), s, increasing.
        values: (m,) or (m, k).

    Returns:
        Times of the middles of those that have samples, (n,); samples and means, (n,) or (n, k).
    """
    block = block_numbers(time, length)
    starts = np.flatnonzero(np.concatenate([[True], np.diff(block) != 0]))
    there = np.isfinite(values)
    count = np.add.reduceat(there.astype(float), starts, axis=0)
    total = np.add.reduceat(np.where(there, values, 0.0), starts, axis=0)
    mean = np.where(count > 0, total / np.maximum(count, 1), np.nan)
    return (block[starts] + 0.5) * length, count, mean


def group_of(name: str, signal: Signal, column: int) -> str:
    """Channel group: sensor, link and direction."""
    channel = signal.channels[column]
    if name == "markers":
        number, axis = int(channel.partition("/")[0].removeprefix("marker")), channel[-1]
        return f"markers/link{2 + (number - 1) // 3}/{axis}"
    return channel if name.startswith("cylinder") else f"{name}/{channel}"


def own_noise(values: Array) -> float:
    """Noise of a channel by its third differences, robustly: what moves slowly does not count."""
    third = np.diff(values[np.isfinite(values)], n=3)
    return float(1.4826 * np.median(np.abs(third)) / np.sqrt(20.0)) if len(third) > 10 else 0.0
