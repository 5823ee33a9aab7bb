"""Gauss rules of any measure: few nodes and weights that integrate polynomials against it exactly."""

from functools import cache

import numpy as np
from numpy.polynomial.legendre import leggauss, legvander

Array = np.ndarray


def points(start: float, stop: float, order: int) -> tuple[Array, Array]:
    """Gauss-Legendre points and weights of an interval, (order,) each: exact to degree 2 order - 1."""
    node, weight = _legendre(order)
    return start + (stop - start) * (node + 1) / 2, (stop - start) / 2 * weight


@cache
def _legendre(order: int) -> tuple[Array, Array]:
    return leggauss(order)


def gauss_rule(x: Array, measure: Array, count: int) -> tuple[Array, Array]:
    """Nodes and weights, (count,) each: exact to degree 2 count - 1 against a measure (m,) at many x (m,).

    They are the eigenvalues of the Jacobi matrix <x p_i p_j> of the measure's orthonormal polynomials, and its mass
    times the squares of their eigenvectors' first components (Golub and Welsch).
    """
    inside = (2 * x - x.min() - x.max()) / np.ptp(x)  # [-1, 1]
    orthonormal = np.linalg.qr(np.sqrt(measure)[:, None] * legvander(inside, count - 1))[0]  # (m, count)
    node, vector = np.linalg.eigh(orthonormal.T @ (x[:, None] * orthonormal))
    return node, measure.sum() * vector[0] ** 2


def radau_rule(start: float, x: Array, measure: Array, count: int) -> tuple[Array, Array]:
    """The same with the first node given, left of all x: exact to degree 2 count - 2."""
    node, weight = gauss_rule(x, measure * (x - start), count - 1)
    weight = weight / (node - start)
    return np.append(start, node), np.append(measure.sum() - weight.sum(), weight)
