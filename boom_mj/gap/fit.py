"""Fitting a candidate: Levenberg-Marquardt over its knobs, nuisances projected out, Broyden's update in between."""

from dataclasses import dataclass

import numpy as np

from boom_mj.effects import Effect
from boom_mj.gap.candidate import Candidate
from boom_mj.gap.metric import Metric

Array = np.ndarray
ITERATIONS = 10
STEP = 0.05  # of a coordinate, for secants
START, ROUGH, SHARP = 0.1, 1e-2, 1e-4  # relative fall of the cost below which it has converged
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


def fit(metric: Metric, candidate: Candidate, enough: float = SHARP, instead: Array | None = None) -> Fit:
    """Fit a candidate on the training entries.

    Args:
        enough: relative fall of the cost below which it has converged.
        instead: another start, (p,), where it costs less.
    """
    train = metric.campaign.train
    low, high = candidate.bounds()
    starts = [np.clip(start, low, high) for start in (candidate.start, instead) if start is not None]

    def residuals(points: list[Array]) -> list[Array]:
        predictions = metric.predict([candidate.at(p) for p in points], training_only=True)
        return [np.where(train, metric.residual(p), 0.0) for p in predictions]

    def cost_of(residual: Array, at: Array) -> float:
        estimate = metric.estimate(residual)
        left = residual[train] - metric.taught @ estimate
        return 0.5 * float(left @ left + estimate @ estimate + at @ at / PRIOR**2)

    def secants(at: Array, residual: Array) -> Array:
        steps = np.where(at + STEP <= high, STEP, -STEP)
        moved = residuals([at + step * row for step, row in zip(steps, np.eye(len(at)))])
        return np.stack([(residual - r) / step for r, step in zip(moved, steps)], axis=1)

    begun = residuals(starts)
    first = int(np.argmin([cost_of(*one) for one in zip(begun, starts)]))
    theta, residual = starts[first], begun[first]
    cost, jacobian, fresh, damping = cost_of(residual, theta), secants(theta, residual), True, 1e-3
    for _ in range(ITERATIONS):
        estimate = metric.estimate(residual)
        slope = jacobian[train].T @ (residual[train] - metric.taught @ estimate) - theta / PRIOR**2
        felt = metric.project(jacobian, metric.free(estimate))[train]
        square = jacobian[train].T @ felt + np.eye(len(theta)) / PRIOR**2
        step = np.linalg.solve(square + damping * np.diag(np.diag(square)), slope)
        new = np.clip(theta + np.clip(step, -10, 10), low, high)
        if np.max(np.abs(new - theta)) < 1e-4:
            break
        (found,) = residuals([new])
        new_cost = cost_of(found, new)
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
