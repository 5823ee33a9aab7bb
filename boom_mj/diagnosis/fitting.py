"""Fitting a candidate: roughly, with nuisances added linearly, and then together with them, all of them simulated."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize_scalar

from boom_mj.diagnosis.candidate import Candidate
from boom_mj.diagnosis.clock import Clock
from boom_mj.diagnosis.linearisation import Linearisation
from boom_mj.effects import Effect
from boom_mj.estimation.least_squares import OPTIONS, gauss_newton
from boom_mj.estimation.linear import LIMIT

Array = np.ndarray


@dataclass(frozen=True, eq=False)
class Fit:
    """A candidate at its best.

    Attributes:
        candidate: what was fitted.
        scaled: best parameters, (p,).
        effects: of that size.
        residual: whitened and cleaned of nuisances; entries held out are filled by `score`, (N,).
        jacobian: whitened d prediction / d parameter on the training entries, zero elsewhere, (N, p).
        cost: half the sum of squares over the training entries.
        rough: how far off the fit might as well have ended, as the cost is rough, (p,).
    """

    candidate: Candidate
    scaled: Array
    effects: tuple[Effect, ...]
    residual: Array
    jacobian: Array
    cost: float
    rough: Array | float = 0.0


def fit(
    model: Linearisation,
    candidate: Candidate,
    enough: float = OPTIONS.rough,
    others: Sequence[Array] = (),
    clock: Clock | None = None,
) -> Fit:
    """Fit a candidate on the training entries: Levenberg-Marquardt, nuisances projected out, Broyden's updates.

    Args:
        enough: relative fall of the cost below which it has converged.
        others: starts, (p,) each, of which one is taken where it costs less.
        clock: where it is over, the best so far is given.
    """
    train, posterior = model.data.train, model.posterior
    low, high = candidate.bounds()
    starts = [np.clip(start, low, high) for start in (candidate.start, *others)]

    def secants(at: Array, residual: Array) -> Array:
        steps, points = candidate.steps(at)
        return np.stack([(residual - r) / step for r, step in zip(model.residuals(points), steps)], axis=1)

    begun = model.residuals([candidate.at(start) for start in starts])
    first = int(np.argmin([_cost(model, *one) for one in zip(begun, starts)]))
    theta, residual = starts[first], begun[first]
    cost, jacobian, fresh = _cost(model, residual, theta), secants(theta, residual), True
    damping = OPTIONS.damping
    for _ in range(OPTIONS.iterations):
        if clock and clock.over(f"the rest of the fit of {candidate.label}"):
            break
        left, estimate = posterior.left(residual)
        slope = jacobian[train].T @ left - theta / OPTIONS.prior**2
        felt = posterior.project(jacobian, posterior.free(estimate))[train]
        square = jacobian[train].T @ felt + np.eye(len(theta)) / OPTIONS.prior**2
        step = np.linalg.solve(square + damping * np.diag(np.diag(square)), slope)
        new = np.clip(theta + np.clip(step, -OPTIONS.longest, OPTIONS.longest), low, high)
        if np.max(np.abs(new - theta)) < OPTIONS.shortest:
            break
        (found,) = model.residuals([candidate.at(new)])
        new_cost = _cost(model, found, new)
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
            damping = max(10 * damping, 10 * OPTIONS.damping)
            if damping > OPTIONS.stuck:
                break
        else:
            jacobian, fresh = secants(theta, residual), True
    return Fit(candidate, theta, candidate.at(theta), model.clean(residual), jacobian, cost)


def grid_starts(model: Linearisation, candidate: Candidate) -> list[Array]:
    """Starts, (p,) each: for every parameter with a grid the size that costs least, the others where they are."""
    return [
        _best_of_grid(model, candidate, k)
        for k, (owner, *_) in enumerate(candidate.parameters)
        if candidate.effects[owner].grid_start
    ]


def _best_of_grid(model: Linearisation, candidate: Candidate, number: int) -> Array:
    """The best size of the grid first, then between its neighbours."""
    grid = candidate.effects[candidate.parameters[number][0]].grid_start
    start, own = candidate.start, np.arange(len(candidate.parameters)) == number

    def cost(size: float) -> float:
        at = np.where(own, size, start)
        (residual,) = model.residuals([candidate.at(at)])
        return _cost(model, residual, at)

    best = int(np.argmin([cost(size) for size in grid]))
    ends = grid[max(best - 1, 0)], grid[min(best + 1, len(grid) - 1)]
    return np.where(own, minimize_scalar(cost, bounds=ends, options={"maxiter": OPTIONS.between}).x, start)


def _cost(model: Linearisation, residual: Array, at: Array) -> float:
    """Half the sum of squares that nuisances leave of a whitened residual, with what priors add."""
    left, estimate = model.posterior.left(residual)
    return 0.5 * float(left @ left + estimate @ estimate + at @ at / OPTIONS.prior**2)


def refine_jointly(model: Linearisation, candidate: Candidate) -> tuple[Linearisation, Fit]:
    """Fit a candidate and the nuisances together, both simulated: Gauss-Newton, with bounds and Broyden's updates.

    Where nuisances move along with a parameter, a fit that adds them linearly stays near where it begins. First
    derivatives of both are the coarse model's: those of different models would not tell how alike the two are.
    Play makes the cost rough: where a step leads that should lower it and does not, the fit might as well have ended.

    Args:
        model: about the machine at which the candidate starts.

    Returns:
        The linearisation rebased at the best, and the fit in it.
    """
    train, count = model.data.train, len(candidate.start)
    (low, high), reach = candidate.bounds(), np.full(len(model.nuisances), LIMIT)
    start = np.clip(candidate.start, low, high)

    def left(at: Array) -> Array:
        here = model.rebased(candidate.at(at[:count]), at[count:], training_only=True)
        return here.residual(here.base)[train] - here.posterior.trained @ at[count:]

    def enough(cost: float) -> float:
        noise = np.count_nonzero(train) / 2
        return OPTIONS.settled * max(1.0, cost / noise) + OPTIONS.patience * max(0.0, cost - noise)

    steps, points = candidate.steps(start)
    moved = model.coarse.predict(points, training_only=True)  # of the machine whose nuisances the columns are
    jacobian = np.stack([model.noise.white(p - model.base) / step for p, step in zip(moved, steps)], axis=1)
    end = gauss_newton(
        left,
        np.hstack([jacobian[train], model.posterior.trained]),
        np.r_[start, model.posterior.estimate(model.residual(model.base))],
        (np.r_[low, -reach], np.r_[high, reach]),
        np.r_[np.full(count, OPTIONS.prior**-2), np.ones(len(reach))],
        enough,
    )
    at, best = end.at[:count], candidate.at(end.at[:count])
    here = model.rebased(best, end.at[count:])
    found, seen = here.clean(here.residual(here.base)), np.where(train[:, None], jacobian, 0.0)
    return here, Fit(candidate, at, best, found, seen, end.cost, end.rough[:count])
