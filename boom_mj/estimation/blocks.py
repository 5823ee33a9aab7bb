"""Means over blocks of time, and the noise of a single sample."""

import numpy as np

Array = np.ndarray


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
