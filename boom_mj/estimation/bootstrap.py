"""Differences of two residuals, resampled or summed over windows of time, within which samples are correlated."""

from dataclasses import dataclass

import numpy as np

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


def closure(windows: Array, before: Array, after: Array) -> Closure:
    """(gap before - gap after) / (gap before - 1) of residuals (n,), and its bootstrap over windows, (n,) of int."""
    names, windows = np.unique(windows, return_inverse=True)
    size = np.bincount(windows)
    sums = [np.bincount(windows, r**2) for r in (before, after)]
    rng = np.random.default_rng(0)
    draws = np.vstack([np.arange(len(names)), rng.integers(len(names), size=(DRAWS, len(names)))])
    old, new = (np.sqrt(s[draws].sum(axis=1) / size[draws].sum(axis=1)) for s in sums)
    share = (old - new) / np.maximum(old - 1, 1e-9)
    low, high = np.quantile(share[1:], [TAIL, 1 - TAIL])
    return Closure(float(share[0]), float(low), float(high))


def worse_by(windows: Array, better: Array, worse: Array) -> tuple[float, float]:
    """Mean square of one residual less that of another, (n,) each, and the standard error of that over windows."""
    difference = worse**2 - better**2
    sums = np.bincount(windows, difference)
    sums = sums[np.bincount(windows) > 0]
    return float(difference.mean()), float(np.sqrt(np.sum((sums - sums.mean()) ** 2)) / len(difference))
