"""Nonlinear least squares whose residual is a simulation: when a fit has converged, and how far it may step."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.linalg import cholesky, solve_triangular
from scipy.optimize import lsq_linear

Array = np.ndarray


@dataclass(frozen=True)
class SolverOptions:
    """Falls are of the cost, half a sum of squares of whitened residuals.

    Attributes:
        iterations: steps at most.
        start, rough, sharp: relative falls of the cost below which a fit has converged: where starts are sought, at
            first, and at last.
        settled: fall that is not worth a step where the gap is 1.
        patience: and share of the cost beyond that of noise: what does not suffice need not be exact.
        idle: steps in a row that promise more and bring less, after which none will.
        between: looks between grid starts.
        prior: deviation of a scaled parameter: keeps what the data do not tell from running away.
        damping: to begin with.
        stuck: damping beyond which no step helps.
        longest, shortest: step of a scaled parameter.
    """

    iterations: int = 10
    start: float = 0.1
    rough: float = 1e-2
    sharp: float = 1e-4
    settled: float = 0.3
    patience: float = 1e-3
    idle: int = 2
    between: int = 10
    prior: float = 30.0
    damping: float = 1e-3
    stuck: float = 1e3
    longest: float = 10.0
    shortest: float = 1e-4


OPTIONS = SolverOptions()


@dataclass(frozen=True, eq=False)
class Minimum:
    """Where a search has ended.

    Attributes:
        at: the parameters x, (p,).
        residual: there, (N,).
        cost: (|r|^2 + sum prior x^2) / 2 there.
        rough: first of the steps at the end that should lower the cost and raised it, 0 if none did, (p,): as far as it
            goes the cost is rough, and the search might as well have ended there.
        reason: why it has ended.
    """

    at: Array
    residual: Array
    cost: float
    rough: Array
    reason: str


def gauss_newton(
    residual: Callable[[Array], Array],
    columns: Array,
    start: Array,
    bounds: tuple[Array, Array],
    prior: Array,
    enough: Callable[[float], float],
    renewed: Callable[[Array], Array | None] = lambda at: None,
    iterations: int = OPTIONS.iterations,
) -> Minimum:
    """Least squares within bounds by Gauss and Newton's steps, with Broyden's updates of the sensitivities.

    Args:
        residual: r of the parameters x, (N,).
        columns: -dr/dx at the start, (N, p); becomes what the updates make of it.
        start: x, (p,).
        bounds: of x, (p,) each.
        prior: 1 / variance of every x about 0, (p,).
        enough: of a cost the fall that is not worth a step.
        renewed: sensitivities at x, (N, p), where updates will not do.
        iterations: steps at most.
    """

    def judged(at: Array) -> tuple[Array, float]:
        left = residual(at)
        return left, 0.5 * float(left @ left + at @ (prior * at))

    at = np.clip(start, *bounds)
    (left, cost), idle, raised, reason = judged(at), 0, list[Array](), f"no end after {iterations} steps"
    for _ in range(iterations):
        root, slope = cholesky(columns.T @ columns + np.diag(prior)), columns.T @ left - prior * at
        step = lsq_linear(root, solve_triangular(root, slope, trans="T"), (bounds[0] - at, bounds[1] - at)).x
        least = enough(cost)
        if slope @ step - 0.5 * np.sum((root @ step) ** 2) < least:
            reason = "converged"
            break
        if idle == OPTIONS.idle:
            reason = f"{idle} steps promised more than they brought"
            break
        there, price = judged(at + step)
        idle = idle + 1 if cost - price < least else 0
        columns += np.outer(left - there - columns @ step, step) / (step @ step)
        if price < cost:
            at, left, cost, raised = at + step, there, price, []
            columns = columns if (anew := renewed(at)) is None else anew
        else:
            raised.append(step)
    return Minimum(at, left, cost, raised[0] if raised else np.zeros(len(at)), reason)
