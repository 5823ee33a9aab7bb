"""Differences of two residuals, resampled or summed over windows of time, within which samples are correlated."""

from dataclasses import dataclass

import numpy as np

from boom_mj.estimation.dataset import Dataset
from boom_mj.estimation.intervals import TAIL

Array = np.ndarray
DRAWS = 400


@dataclass(frozen=True)
class Closure:
    """How much of a gap above the floor went away, with a 95 % interval."""

    value: float
    low: float
    high: float


def gap(residual: Array, rows: Array) -> float:
    """Root mean square of a whitened residual over the given entries: 1 is the floor; NaN where there are none."""
    return float(np.sqrt(np.mean(residual[rows] ** 2))) if rows.any() else float("nan")


def resampled_means(windows: Array, values: Array) -> Array:
    """Means over all entries of rows of values (k, n), as they are and with windows (n,) drawn anew, (draws + 1, k)."""
    names, windows = np.unique(windows, return_inverse=True)
    size = np.bincount(windows)
    sums = np.array([np.bincount(windows, row) for row in values])  # (k, windows)
    rng = np.random.default_rng(0)
    draws = np.vstack([np.arange(len(names)), rng.integers(len(names), size=(DRAWS, len(names)))])
    return np.array([s[draws].sum(axis=1) for s in sums]).T / size[draws].sum(axis=1)[:, None]


def closure(windows: Array, before: Array, after: Array) -> Closure:
    """(gap before - gap after) / (gap before - floor) of residuals (n,), and its bootstrap over windows, (n,) of int.

    The floor is 1, or what is left if that is less.
    """
    old, new = np.sqrt(resampled_means(windows, np.array([before**2, after**2]))).T
    share = (old - new) / np.maximum(old - np.minimum(new, 1.0), 1e-9)
    low, high = np.quantile(share[1:], [TAIL, 1 - TAIL])
    return Closure(float(share[0]), float(low), float(high))


def worse_by(windows: Array, better: Array, worse: Array) -> tuple[float, float]:
    """Mean square of one residual less that of another, (n,) each, and the standard error of that over windows."""
    difference = worse**2 - better**2
    sums = np.bincount(windows, difference)
    sums = sums[np.bincount(windows) > 0]
    return float(difference.mean()), float(np.sqrt(np.sum((sums - sums.mean()) ** 2)) / len(difference))


def log_squares(data: Dataset, residuals: Array) -> tuple[Array, Array]:
    """Logarithms of held-out mean squares, by channel and window, (k, cells), and windows of the cells, (cells,).

    Above the floor residuals (k, N) are the model's error, of another size in every channel and window. A Gaussian of
    a size fitted in each has the logarithm as its score, so that the worst moments of a machine do not outvote all
    others. The floor, 1, is the least that counts.
    """
    rows = data.held_out
    windows = np.unique(data.windows[rows], return_inverse=True)[1]
    names, cell = np.unique(data.channel_of[rows] * (windows.max() + 1) + windows, return_inverse=True)
    squares = np.array([np.bincount(cell, residual[rows] ** 2) for residual in residuals]) / np.bincount(cell)
    return np.log(np.maximum(squares, 1.0)), names % (windows.max() + 1)


def mean_over(clusters: Array, values: Array) -> tuple[float, float]:
    """Mean of values (n,), and its standard error over clusters, (n,) of int."""
    sums = np.bincount(clusters, values - values.mean())[np.unique(clusters)]
    return float(values.mean()), float(np.sqrt(np.sum(sums**2)) / len(values))
