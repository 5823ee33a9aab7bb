"""Fitting a candidate: roughly, with nuisances added linearly, and then together with them, all of them simulated."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import cholesky, solve_triangular
from scipy.optimize import lsq_linear, minimize_scalar

from boom_mj.diagnosis.candidate import Candidate
from boom_mj.diagnosis.linearisation import LIMIT, Metric, anchored, coarsely
from boom_mj.effects import Effect
from boom_mj.systems.system import Hypothesis

Array = np.ndarray
ITERATIONS = 10
START, ROUGH, SHARP = 0.1, 1e-2, 1e-4  # relative fall of the cost below which a fit has converged
SETTLED = 0.3  # fall of the cost, half a sum of squares, that is not worth a step where the gap is 1
PATIENCE = 1e-3  # and share of the cost beyond that of noise: what does not suffice need not be exact
IDLE = 2  # steps in a row that promise more and bring less, after which none will
BETWEEN = 10  # looks between rungs
PRIOR = 30.0  # deviation of a coordinate: keeps what the data do not tell from running away


@dataclass(frozen=True)
class Fit:
    """A candidate at its best.

    Attributes:
        candidate: what was fitted.
        coordinates: best, (p,).
        effects: at the best coordinates.
        residual: whitened and cleaned of nuisances; entries held out are filled by `judge`, (N,).
        jacobian: whitened d prediction / d coordinate on the training entries, zero elsewhere, (N, p).
        cost: half the sum of squares over the training entries.
    """

    candidate: Candidate
    coordinates: Array
    effects: tuple[Effect, ...]
    residual: Array
    jacobian: Array
    cost: float


def fit(metric: Metric, candidate: Candidate, enough: float = ROUGH, others: Sequence[Array] = ()) -> Fit:
    """Fit a candidate on the training entries: Levenberg-Marquardt, nuisances projected out, Broyden's updates.

    Args:
        enough: relative fall of the cost below which it has converged.
        others: starts, (p,) each, of which one is taken where it costs less.
    """
    train = metric.campaign.train
    low, high = candidate.bounds()
    starts = [np.clip(start, low, high) for start in (candidate.start, *others)]

    def secants(at: Array, residual: Array) -> Array:
        steps, points = candidate.steps(at)
        return np.stack([(residual - r) / step for r, step in zip(_residuals(metric, points), steps)], axis=1)

    begun = _residuals(metric, [candidate.at(start) for start in starts])
    first = int(np.argmin([_cost(metric, *one) for one in zip(begun, starts)]))
    theta, residual = starts[first], begun[first]
    cost, jacobian, fresh, damping = _cost(metric, residual, theta), secants(theta, residual), True, 1e-3
    for _ in range(ITERATIONS):
        estimate = metric.estimate(residual)
        slope = jacobian[train].T @ (residual[train] - metric.taught @ estimate) - theta / PRIOR**2
        felt = metric.project(jacobian, metric.free(estimate))[train]
        square = jacobian[train].T @ felt + np.eye(len(theta)) / PRIOR**2
        step = np.linalg.solve(square + damping * np.diag(np.diag(square)), slope)
        new = np.clip(theta + np.clip(step, -10, 10), low, high)
        if np.max(np.abs(new - theta)) < 1e-4:
            break
        (found,) = _residuals(metric, [candidate.at(new)])
        new_cost = _cost(metric, found, new)
        if new_cost < cost:
            moved = new - theta
            miss = (residual - found) - jacobian @ moved
            jacobian = jacobian + np.outer(miss, moved) / (moved @ moved)
            done = cost - new_cost < enough * cost
            theta, residual, cost, damping = new, found, new_cost, damping / 10
            if done and fresh:
                break
            fresh = not done and fresh
            if done:
                jacobian, fresh = secants(theta, residual), True
        elif fresh:
            damping = max(10 * damping, 1e-2)
            if damping > 1e3:
                break
        else:
            jacobian, fresh = secants(theta, residual), True
    return Fit(candidate, theta, candidate.at(theta), metric.clean(residual), jacobian, cost)


def climb(metric: Metric, candidate: Candidate) -> list[Array]:
    """Starts, (p,) each: for every knob that has rungs the size that costs least, the others where they are."""
    return [
        _climbed(metric, candidate, k)
        for k, (owner, *_) in enumerate(candidate.knobs)
        if candidate.effects[owner].rungs
    ]


def _climbed(metric: Metric, candidate: Candidate, number: int) -> Array:
    """The best rung of a knob first, then between its neighbours."""
    rungs = candidate.effects[candidate.knobs[number][0]].rungs
    start, own = candidate.start, np.arange(len(candidate.knobs)) == number

    def cost(size: float) -> float:
        at = np.where(own, size, start)
        (residual,) = _residuals(metric, [candidate.at(at)])
        return _cost(metric, residual, at)

    best = int(np.argmin([cost(rung) for rung in rungs]))
    ends = rungs[max(best - 1, 0)], rungs[min(best + 1, len(rungs) - 1)]
    return np.where(own, minimize_scalar(cost, bounds=ends, options={"maxiter": BETWEEN}).x, start)


def _residuals(metric: Metric, hypotheses: Sequence[Hypothesis]) -> list[Array]:
    """Whitened residuals of hypotheses on the training entries, zero elsewhere, (N,) each."""
    train = metric.campaign.train
    return [np.where(train, metric.residual(p), 0.0) for p in metric.predict(hypotheses, training_only=True)]


def _cost(metric: Metric, residual: Array, at: Array) -> float:
    """Half the sum of squares that nuisances leave of a whitened residual, with what priors add."""
    estimate = metric.estimate(residual)
    left = residual[metric.campaign.train] - metric.taught @ estimate
    return 0.5 * float(left @ left + estimate @ estimate + at @ at / PRIOR**2)


def settle(metric: Metric, candidate: Candidate) -> tuple[Metric, Fit]:
    """Fit a candidate and the nuisances together, both simulated: Gauss-Newton, with bounds and Broyden's updates.

    Where nuisances move along with a knob, a fit that adds them linearly stays near where it begins. First derivatives
    of both are the coarse model's: those of different models would not tell how alike the two are.

    Args:
        metric: about the machine at which the candidate starts.

    Returns:
        The metric anchored at the best, and the fit in it.
    """
    train, count = metric.campaign.train, len(candidate.start)
    (low, high), reach = candidate.bounds(), np.full(len(metric.nuisances), LIMIT)
    prior = np.r_[np.full(count, PRIOR**-2), np.ones(len(metric.nuisances))]

    def simulated(at: Array) -> tuple[Metric, Array, float]:
        here = anchored(metric, candidate.at(at[:count]), at[count:], training_only=True)
        left = here.residual(here.base)[train] - here.taught @ at[count:]
        return here, left, 0.5 * float(left @ left + at @ (prior * at))

    at = np.r_[np.clip(candidate.start, low, high), metric.estimate(metric.residual(metric.base))]
    here, left, cost = simulated(at)
    steps, points = candidate.steps(at[:count])
    moved = coarsely(metric).predict(points, training_only=True)  # of the machine whose nuisances the columns are
    jacobian = np.stack([metric.white(p - metric.base) / step for p, step in zip(moved, steps)], axis=1)
    columns, idle = np.hstack([jacobian[train], metric.taught]), 0
    for _ in range(ITERATIONS):
        root, slope = cholesky(columns.T @ columns + np.diag(prior)), columns.T @ left - prior * at
        ends = np.r_[low, -reach] - at, np.r_[high, reach] - at
        step = lsq_linear(root, solve_triangular(root, slope, trans="T"), ends).x
        least = SETTLED * max(1.0, 2 * cost / len(left)) + PATIENCE * max(0.0, cost - len(left) / 2)
        if slope @ step - 0.5 * np.sum((root @ step) ** 2) < least or idle == IDLE:
            break
        there, rest, price = simulated(at + step)
        idle = idle + 1 if cost - price < least else 0
        columns += np.outer(left - rest - columns @ step, step) / (step @ step)
        if price < cost:
            at, here, left, cost = at + step, there, rest, price
    best = candidate.at(at[:count])
    here = anchored(metric, best, at[count:])
    found = here.clean(here.residual(here.base))
    return here, Fit(candidate, at[:count], best, found, np.where(train[:, None], jacobian, 0.0), cost)
