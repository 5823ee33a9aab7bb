"""Nuisances that no one calls a cause, as linear columns with priors, estimated in training and removed everywhere.

With columns b_i and prior deviations s_i, whitened B = [b_i s_i],

    <x, y> = x^T y - x^T B (1 + B^T B)^-1 B^T y        (sums over training entries)

is the inner product in which hypotheses are screened and fitted. A nuisance never exceeds a few prior deviations: one
that would is held there and leaves B.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg import cholesky, solve_triangular
from scipy.optimize import lsq_linear

from boom_mj.estimation.noise import NoiseModel

Array = np.ndarray
LIMIT = 2.5  # prior deviations: what goes further is no nuisance but a cause


@dataclass(frozen=True, eq=False)
class LinearPosterior:
    """Nuisances of a dataset.

    Attributes:
        noise: that whitens.
        columns: what nuisances change per prior deviation, (N, m).
    """

    noise: NoiseModel
    columns: Array

    @cached_property
    def basis(self) -> Array:
        """Whitened columns, (N, m)."""
        return np.array([self.noise.white(column) for column in self.columns.T]).reshape(self.columns.T.shape).T

    @cached_property
    def trained(self) -> Array:
        """The basis on the training entries, (training, m)."""
        return self.basis[self.noise.data.train]

    @cached_property
    def curvature(self) -> Array:
        """1 + B^T B over the training entries, (m, m)."""
        return np.eye(self.columns.shape[1]) + self.trained.T @ self.trained

    def estimate(self, white: Array) -> Array:
        """Nuisances that whitened training entries ask for, in units of their prior deviation, within +-LIMIT, (m,)."""
        if not self.columns.shape[1]:
            return np.zeros(0)
        slope = self.trained.T @ white[self.noise.data.train]
        root = cholesky(self.curvature)  # upper: |root x - root^-T slope|^2 is what x minimises
        return lsq_linear(root, solve_triangular(root, slope, trans="T"), (-LIMIT, LIMIT)).x

    def free(self, estimate: Array) -> Array:
        """Nuisances that are not at their limit, (m,) of bool."""
        return np.abs(estimate) < LIMIT * (1 - 1e-6)

    def clean(self, white: Array) -> Array:
        """A whitened residual (N,) without what nuisances explain of its training entries."""
        return white - self.basis @ self.estimate(white)

    def left(self, white: Array) -> tuple[Array, Array]:
        """What nuisances leave of whitened training entries, (training,), and the nuisances, (m,)."""
        estimate = self.estimate(white)
        return white[self.noise.data.train] - self.trained @ estimate, estimate

    def project(self, columns: Array, free: Array) -> Array:
        """Whitened columns (N, k) as they are felt while the free nuisances follow."""
        inner = self.curvature[np.ix_(free, free)]
        follow = np.linalg.solve(inner, self.trained[:, free].T @ columns[self.noise.data.train])
        return columns - self.basis[:, free] @ follow
