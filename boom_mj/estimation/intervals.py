"""Variances of estimates whose residuals are correlated."""

from collections.abc import Sequence

import numpy as np
from scipy.special import ndtri, stdtrit

Array = np.ndarray
LEVEL = 0.95  # of every interval
TAIL = (1 - LEVEL) / 2
Z95 = float(ndtri(1 - TAIL))  # standard deviations at the end of such an interval, 1.96
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
            wider = count / (count - 1) * (stdtrit(count - 1, 1 - TAIL) / Z95) ** 2
            variances.append(wider * np.diag(inverse @ (sums.T @ sums) @ inverse))
    return np.max(variances, axis=0)
