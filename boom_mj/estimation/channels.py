"""Channels of recordings as means over blocks."""

from dataclasses import dataclass, replace

import numpy as np

from boom_mj.recording import Recording

Array = np.ndarray


@dataclass(frozen=True)
class Channel:
    """One channel of one recording, its stretch of the long vector.

    Attributes:
        recording: index.
        signal, column: where the channel lies in the recording.
        group: sensor and direction, such as "imu/link5/specific_force/y" or "markers/link4/z".
        blocks: numbers of those that were sampled, (n,) of int.
        time: of their middles, (n,), s from the start of the recording.
        count: samples of a block, (n,); 0 where all are hidden.
        measured: means of its blocks, (n,).
        noise: of a single sample.
        rounding: of the means by the resolution of what was recorded, which samples alike do not average away, (n,).
    """

    recording: int
    signal: str
    column: int
    group: str
    blocks: Array
    time: Array
    count: Array
    measured: Array
    noise: float
    rounding: Array

    @property
    def deviation(self) -> Array:
        """Standard deviation of the means, (n,)."""
        return np.hypot(self.noise / np.sqrt(np.maximum(self.count, 1)), self.rounding)


@dataclass(frozen=True, eq=False)
class Table:
    """Channels of one recording as block means on one grid of times.

    Attributes:
        log: the recording.
        channels: k of them.
        start_s: of the recording.
        time: middles of the blocks, (n,), s from the start.
        mean: (n, k); NaN where a channel has no sample.
        noise: standard deviation of the means, (n, k).
    """

    log: Recording
    channels: tuple[Channel, ...]
    start_s: float
    time: Array
    mean: Array
    noise: Array

    def saying(self, means: Array) -> "Table":
        """With other means of the blocks that were sampled, channel by channel, (m,)."""
        mean, first = np.full(self.noise.shape, np.nan), 0
        for column, channel in enumerate(self.channels):
            mean[channel.blocks, column] = means[first : (first := first + len(channel.blocks))]
        return replace(self, mean=mean)
