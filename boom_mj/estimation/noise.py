"""What counts as a difference: noise, and the model's own error.

Residuals are whitened by V = D + e e^T in every channel, D = noise^2 + spread^2, and by 1 + H H^T in every recording, H
what unsure measured states at its start change in it. What other levels of a simulation say, of its hinges, its steps,
the noise of measured motion, has a size, their doubts; the spread is a share of these, added in squares, within half a
second, and e, a share of their sum as it is, may be wrong all along a channel. What latent inputs explain does not
count.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.ndimage import maximum_filter1d

from boom_mj.estimation.dataset import Dataset
from boom_mj.estimation.latent_input import LatentInput

Array = np.ndarray


@dataclass(frozen=True)
class NoiseOptions:
    """How model error counts.

    Attributes:
        spread_share: share of what refining changes that may be wrong at every moment.
        reach_blocks: within which it is carried, for phase.
        failed: deviations that stand for a simulation that failed.
    """

    spread_share: float = 0.5
    reach_blocks: int = 5
    failed: float = 1e3


OPTIONS = NoiseOptions()


@dataclass(frozen=True, eq=False)
class NoiseModel:
    """Whitening of a dataset's entries.

    Attributes:
        data: whose entries.
        weight: 1 / sqrt(D), 0 where nothing was measured, (N,).
        error: e, (N,).
        starts: H, (N, p).
        blur_s: length of stretches of which only the mean counts; None where every entry does.
        latent: what they explain does not count; None where nothing has any.
    """

    data: Dataset
    weight: Array
    error: Array
    starts: Array | None = None
    blur_s: float | None = None
    latent: LatentInput | None = None

    @property
    def plain(self) -> "NoiseModel":
        """Without blur and latent inputs."""
        return replace(self, blur_s=None, latent=None)

    @cached_property
    def _scaled_error(self) -> tuple[Array, Array]:
        """e over the noise, (N,), and how much of it counts as wrong all along its channel, (channels,)."""
        error = self.error * self.weight
        square = np.bincount(self.data.channel_of, error**2, len(self.data.channels))
        return error, (1 - 1 / np.sqrt(1 + square)) / np.maximum(square, 1e-12)

    @cached_property
    def _unsure(self) -> list[tuple[Array, Array]]:
        """Of every recording the directions of H over the noise, (n, p), and how much of them does not count, (p,)."""
        if self.starts is None:
            return []
        found = []
        for index in range(len(self.data.recordings)):
            rows = self.data.rows(index)
            basis, size, _ = np.linalg.svd(self.starts[rows] * self.weight[rows, None], full_matrices=False)
            found.append((basis, 1 - 1 / np.sqrt(1 + size**2)))
        return found

    def white(self, vector: Array) -> Array:
        """Whitened, zero where nothing was measured; huge where the simulation failed."""
        scale = np.where(self.weight > 0, self.weight, 1.0)
        scaled = np.where(self.weight > 0, np.where(np.isfinite(vector), vector * scale, OPTIONS.failed), 0.0)
        error, share = self._scaled_error
        along = np.bincount(self.data.channel_of, error * scaled, len(share))
        whole = scaled - (share * along)[self.data.channel_of] * error
        for index, (basis, less) in enumerate(self._unsure):
            rows = self.data.rows(index)
            whole[rows] -= basis @ (less * (basis.T @ whole[rows]))
        whole = whole if self.latent is None else self.latent.without(whole)
        return whole if self.blur_s is None else self.data.blurred(whole, self.blur_s)

    def whitened(self, rows: slice, columns: Array) -> Array:
        """Columns (n, k) of a recording's entries, whitened but for latent inputs and blur."""
        (error, share), kind = self._scaled_error, columns.dtype
        scaled = columns * self.weight[rows, None].astype(kind)
        for number in np.unique(self.data.channel_of[rows]):
            part = self.data.stretch(number)
            own, off = slice(part.start - rows.start, part.stop - rows.start), error[part].astype(kind)
            scaled[own] -= np.outer(off, share[number].astype(kind) * (off @ scaled[own]))
        if self._unsure:
            basis, less = self._unsure[self.data.recording_of[rows.start]]
            scaled -= (basis @ (less[:, None] * (basis.T @ scaled))).astype(kind)
        return scaled


def noise_model(data: Dataset, doubts: Array, along_share: float, starts: Array | None = None) -> NoiseModel:
    """Noise of a dataset, and error of a model: each of `doubts` (k, N) may be wrong, of their sum a share all along.

    Of `starts` (N, p) each column is what a deviation of a state at the start changes.

    What they do at a moment adds up as errors that know nothing of each other: that two cancel there is chance.
    """
    variance = data.noise**2 + (OPTIONS.spread_share * _carried(data, np.sqrt(np.sum(doubts**2, axis=0)))) ** 2
    weight = np.where(data.used, 1 / np.sqrt(np.where(data.used, variance, 1.0)), 0.0)
    return NoiseModel(data, weight, along_share * doubts.sum(axis=0), starts)


def _carried(data: Dataset, size: Array) -> Array:
    """Each channel's largest value within reach."""
    out = np.empty_like(size)
    for number in range(len(data.channels)):
        part = data.stretch(number)
        out[part] = maximum_filter1d(np.nan_to_num(size[part]), 2 * OPTIONS.reach_blocks + 1, mode="nearest")
    return out
