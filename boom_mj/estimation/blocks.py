"""Means over blocks of time, and the noise of a single sample."""

import numpy as np

Array = np.ndarray
REPEATS = 2  # samples per value, from which a channel's values are steps of its resolution


def block_numbers(time: Array, length_s: float) -> Array:
    """Number of the block in which each time lies, (m,) of int."""
    return np.floor(time / length_s + 1e-6).astype(int)


def block_means(time: Array, values: Array, length_s: float) -> tuple[Array, Array, Array]:
    """Means over blocks that leave out NaN.

    Args:
        time: (m,), s, increasing.
        values: (m,) or (m, k).

    Returns:
        Times of the middles of those that have samples, (n,); samples and means, (n,) or (n, k).
    """
    block = block_numbers(time, length_s)
    starts = np.flatnonzero(np.concatenate([[True], np.diff(block) != 0]))
    there = np.isfinite(values)
    count = np.add.reduceat(there.astype(float), starts, axis=0)
    total = np.add.reduceat(np.where(there, values, 0.0), starts, axis=0)
    mean = np.where(count > 0, total / np.maximum(count, 1), np.nan)
    return (block[starts] + 0.5) * length_s, count, mean


def own_noise(values: Array) -> float:
    """Noise of a channel by its third differences, robustly: what moves slowly does not count."""
    third = np.diff(values[np.isfinite(values)], n=3)
    return float(1.4826 * np.median(np.abs(third)) / np.sqrt(20.0)) if len(third) > 10 else 0.0


def rounding_noise(time: Array, values: Array, length_s: float) -> Array:
    """Deviation of means over blocks by rounding: evenly within a step, less where samples lie on several, (n,).

    Args:
        time, values: (m,); see `block_means`.
    """
    block, there = block_numbers(time, length_s), np.isfinite(values)
    steps = np.unique(values[there])
    if len(steps) < 2 or REPEATS * len(steps) > there.sum():
        return np.zeros(len(np.unique(block)))
    pairs = np.unique(np.stack([block[there], np.searchsorted(steps, values[there])]), axis=1)
    several = np.bincount(pairs[0], minlength=block[-1] + 1)[np.unique(block)]
    return np.median(np.diff(steps)) / np.sqrt(12 * np.maximum(several, 1))
