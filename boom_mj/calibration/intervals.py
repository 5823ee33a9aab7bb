"""Variances of estimates whose residuals are correlated."""

from collections.abc import Sequence

import numpy as np

Array = np.ndarray


def robust_variance(inverse: Array, score: Array, clusters: Sequence[Array]) -> Array:
    """The largest of diag H^-1 and diag H^-1 (sum g g^T) H^-1, with scores g summed over clusters, (p,).

    Args:
        inverse: of the information H, (p, p).
        score: derivative of the cost by entry and coordinate, (N, p).
        clusters: alternatives; each numbers the cluster of every entry, (N,) of int.
    """
    variances = [np.diag(inverse)]
    for cluster in clusters:
        sums = np.stack([np.bincount(cluster, column) for column in score.T], axis=1)
        variances.append(np.diag(inverse @ (sums.T @ sums) @ inverse))
    return np.max(variances, axis=0)
