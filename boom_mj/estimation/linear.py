"""Nuisances that no one calls a cause, as linear columns with priors, estimated in training and removed everywhere.

With columns b_i and prior deviations s_i, whitened B = [b_i s_i],

    <x, y> = x^T y - x^T B (1 + B^T B)^-1 B^T y        (sums over training entries)

is the inner product in which hypotheses are screened and fitted. A nuisance never exceeds a few prior deviations: one
that would is held there and leaves B.

Training tells of them 1 + B^T B; what it leaves open makes the prediction of what is held out uncertain, all along a
recording. With H the rows of B there, the residual has the variance

    V = 1 + H (1 + B^T B)^-1 H^T.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Self

import numpy as np
from scipy.linalg import cholesky, solve_triangular
from scipy.optimize import lsq_linear

from boom_mj.estimation.noise import NoiseModel

Array = np.ndarray
ROWS = 4096  # of single precision that are multiplied at once, in double precision
LIMIT = 2.5  # prior deviations: what goes further is no nuisance but a cause


@dataclass(frozen=True, eq=False)
class Basis:
    """What nuisances change, whitened: of single precision, by far finer than noise; products are of double.

    Attributes:
        noise: that whitens.
        columns: what nuisances change per prior deviation, (N, m).
    """

    noise: NoiseModel
    columns: Array

    @cached_property
    def whole(self) -> Array:
        """Whitened columns, (N, m)."""
        found = np.empty(self.columns.shape, np.float32)
        for k, column in enumerate(self.columns.T):
            found[:, k] = self.noise.white(column)
        return found

    @cached_property
    def trained(self) -> Array:
        """The same on the training entries: B, (training, m)."""
        return self.whole[self.noise.data.train]

    @cached_property
    def curvature(self) -> Array:
        """1 + B^T B, (m, m)."""
        return np.eye(self.columns.shape[1]) + _product(self.trained, self.trained)

    def slopes(self, white: Array) -> Array:
        """B^T y of whitened training entries y, (training,) or (training, k); (m,) or (m, k)."""
        return _product(self.trained, white)


@dataclass(frozen=True, eq=False)
class LinearPosterior:
    """Nuisances of a dataset.

    Attributes:
        basis: what they change.
        some: which of them there are, (m,) of bool.
    """

    basis: Basis
    some: Array

    @classmethod
    def of(cls, noise: NoiseModel, columns: Array) -> Self:
        """Of nuisances that there all are; see `Basis`."""
        return cls(Basis(noise, columns), np.ones(columns.shape[1], bool))

    @property
    def noise(self) -> NoiseModel:
        return self.basis.noise

    @property
    def trained(self) -> Array:
        """Whitened columns on the training entries, 0 for nuisances that there are not, (training, m)."""
        return self.basis.trained if self.some.all() else self.basis.trained * self.some

    @cached_property
    def _root(self) -> Array:
        """Upper root of the curvature of those that there are."""
        return cholesky(self.basis.curvature[np.ix_(self.some, self.some)])

    def estimate(self, white: Array) -> Array:
        """Nuisances that whitened training entries ask for, in units of their prior deviation, within +-LIMIT, (m,)."""
        found = np.zeros(len(self.some))
        if self.some.any():
            found[self.some] = within_limits(self._root, self.basis.slopes(white[self.noise.data.train])[self.some])
        return found

    def free(self, estimate: Array) -> Array:
        """Nuisances that there are and that are not at their limit, (m,) of bool."""
        return self.some & (np.abs(estimate) < LIMIT * (1 - 1e-6))

    def clean(self, white: Array) -> Array:
        """A whitened residual (N,) without what nuisances explain of its training, whitened by V where it is held out.

        Each recording by itself: what changed in one is not seen in another.
        """
        left = white - self.basis.whole @ self.estimate(white).astype(np.float32)
        for rows, unsure in self._predicted:
            columns = self.basis.whole[rows]
            left[rows] -= columns @ (unsure @ _product(columns, left[rows])).astype(np.float32)
        return left

    @cached_property
    def _predicted(self) -> list[tuple[Array, Array]]:
        """Of every recording the entries held out, (n,), and K of V^(-1/2) = 1 - H K H^T, (m, m)."""
        if not self.some.any():
            return []
        data, root = self.noise.data, solve_triangular(self._root, np.eye(len(self._root)))
        found = []
        for index in np.unique(data.recording_of[data.held_out]):
            rows = np.flatnonzero(data.held_out & (data.recording_of == index))
            columns = self.basis.whole[rows][:, self.some]
            spread, turn = np.linalg.eigh(root.T @ _product(columns, columns) @ root)
            deviation, turned = np.sqrt(1 + np.maximum(spread, 0.0)), np.zeros((len(self.some), len(root)))
            turned[self.some] = root @ turn
            found.append((rows, turned / (deviation * (1 + deviation)) @ turned.T))
        return found

    def left(self, white: Array) -> tuple[Array, Array]:
        """What nuisances leave of whitened training entries, (training,), and the nuisances, (m,)."""
        estimate = self.estimate(white)
        return white[self.noise.data.train] - self.basis.trained @ estimate.astype(np.float32), estimate

    def project(self, columns: Array, free: Array) -> Array:
        """Whitened columns (N, k) as they are felt while the free nuisances follow."""
        free, follow = free & self.some, np.zeros((len(free), columns.shape[1]), np.float32)
        slopes = self.basis.slopes(columns[self.noise.data.train])[free]
        follow[free] = np.linalg.solve(self.basis.curvature[np.ix_(free, free)], slopes)
        return columns - self.basis.whole @ follow


def within_limits(root: Array, slope: Array) -> Array:
    """Nuisances within +-LIMIT by the upper root of 1 + B^T B, (m, m), and B^T y, (m,)."""
    return lsq_linear(root, solve_triangular(root, slope, trans="T"), (-LIMIT, LIMIT)).x


def _product(columns: Array, white: Array) -> Array:
    """A^T y in double precision, (m,) or (m, k)."""
    parts = (part.T.astype(float) @ own for part, own in zip(_rows(columns), _rows(white)))
    return sum(parts, np.zeros((columns.shape[1], *white.shape[1:])))


def _rows(matrix: Array) -> Iterator[Array]:
    """A matrix by its rows, some at a time."""
    return (matrix[start : start + ROWS] for start in range(0, len(matrix), ROWS))
