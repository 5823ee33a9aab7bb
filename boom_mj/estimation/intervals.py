"""Variances of estimates whose residuals are correlated."""

from collections.abc import Sequence

import numpy as np
from scipy.stats import norm as normal
from scipy.stats import t as student

Array = np.ndarray
SURE = 0.975  # upper end of a 95 % interval
FEWEST = 4  # clusters


def robust_variance(inverse: Array, score: Array, clusters: Sequence[Array]) -> Array:
    """The largest of diag H^-1 and diag H^-1 (sum g g^T) H^-1, with scores g summed over clusters, (p,).

    Of G clusters the sum is G / (G - 1) times what it seems, and a 95 % interval is Student's with G - 1 degrees of
    freedom; the variance is that of a normal distribution with such an interval. Fewer than FEWEST tell nothing.

    Args:
        inverse: of the information H, (p, p).
        score: derivative of the cost by entry and coordinate, (N, p).
        clusters: alternatives; each numbers the cluster of every entry, (N,) of int.
    """
    variances = [np.diag(inverse)]
    for cluster in clusters:
        count = len(np.unique(cluster))
        if count >= FEWEST:
            sums = np.stack([np.bincount(cluster, column) for column in score.T], axis=1)
            wider = count / (count - 1) * (student.ppf(SURE, count - 1) / normal.ppf(SURE)) ** 2
            variances.append(wider * np.diag(inverse @ (sums.T @ sums) @ inverse))
    return np.max(variances, axis=0)
