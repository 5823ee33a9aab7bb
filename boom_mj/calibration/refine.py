"""The joint refinement: all recordings, all scaled parameters at once.

Residuals are whitened: measured less predicted less what finer hinges would add, over noise and model error.
Predictions are of the middle level; sensitivities are secants of the coarse one, and stay while the parameters do.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from boom_mj.calibration.evidence import COARSE, MIDDLE, predict
from boom_mj.calibration.identify import covariance
from boom_mj.calibration.parameters import OFFSET, Parameterisation, Variant
from boom_mj.estimation.bootstrap import gap
from boom_mj.estimation.dataset import Dataset
from boom_mj.estimation.intervals import robust_variance
from boom_mj.estimation.least_squares import gauss_newton
from boom_mj.estimation.noise import NoiseModel
from boom_mj.systems.predictor import Predictor

Array = np.ndarray
NEAR = 0.05  # of a logarithm, within which sensitivities stay
EVALUATIONS = 15  # of the refinement
ENOUGH, ROUGH = 0.03, 3.0  # fall of the cost at which it ends: one deviation is a fall of 0.5
SYSTEMATIC = 0.3  # share of what the hinges' extrapolation moves that may be wrong, by machines of six hinges


@dataclass(frozen=True, eq=False)
class Refined:
    """Scaled parameters at their best, and how sure they are.

    Attributes:
        free: of the scaled parameters.
        scaled parameters: (p,).
        deviation: standard deviations, (p,).
        systematic: their part that comes from the number of hinges, (p,).
        residual: whitened, (N,).
        jacobian: whitened sensitivities, (N, p).
        weight: 1 / deviation of every entry, (N,).
        at_bound: names of scaled parameters that stopped at a bound.
        status: how the search ended.
    """

    free: Parameterisation
    scaled: Array
    deviation: Array
    systematic: Array
    residual: Array
    jacobian: Array
    weight: Array
    at_bound: tuple[str, ...]
    status: str

    @property
    def variant(self) -> Variant:
        """The machine and the zero offsets."""
        return self.free.at(self.scaled)

    def weighted(self, weight: Array) -> Array:
        """The sensitivities, whitened by another weight, (N, p)."""
        return self.jacobian * (weight / np.where(self.weight > 0, self.weight, 1.0))[:, None]


def sensitivities(predictor: Predictor, free: Parameterisation, scaled: Array, noise: NoiseModel) -> Array:
    """Whitened d prediction / d scaled parameter, (N, size), by secants of the coarse level."""
    steps = np.where(scaled + free.steps <= free.bounds[1], free.steps, -free.steps)
    points = [scaled, *(scaled + step * row for step, row in zip(steps, np.eye(free.size)))]
    base, *moved = predict(predictor, [free.at(point) for point in points], COARSE)
    return np.stack([np.nan_to_num((m - base) / step) * noise.weight for m, step in zip(moved, steps)], axis=1)


def refine(
    predictor: Predictor,
    free: Parameterisation,
    start: Array,
    error: tuple[Array, NoiseModel],
    jacobian: Array | None = None,
    enough: float = ENOUGH,
    tell: Callable[[str], None] = lambda line: None,
) -> Refined:
    """Fit all scaled to all recordings.

    Args:
        start: scaled parameters, (p,).
        error: what finer hinges add, (N,), and the noise: `model_error` near there.
        jacobian: whitened sensitivities there, (N, p), where they are known.
        enough: fall of the cost at which it ends.
        tell: hears one line per prediction.
    """
    (finer, noise), data = error, predictor.data
    exact, there = sensitivities(predictor, free, start, noise) if jacobian is None else jacobian, start

    def residual(scaled: Array) -> Array:
        (prediction,) = predict(predictor, [free.at(scaled)], MIDDLE)
        white = noise.white(data.measured - prediction - finer)
        tell(f"gap {gap(white, data.used):.3f}")
        return white

    def renewed(scaled: Array) -> Array | None:
        nonlocal exact, there
        if np.max(np.abs(scaled - there)) <= NEAR:
            return None
        exact, there = sensitivities(predictor, free, scaled, noise), scaled
        return exact.copy()

    def least(cost: float) -> float:
        return enough * max(1.0, 2 * cost / np.count_nonzero(data.used))

    (low, high), prior = free.bounds, np.zeros(free.size)
    found = gauss_newton(residual, exact.copy(), start, (low, high), prior, least, renewed, EVALUATIONS)
    deviation, systematic = deviations(data, free, exact, found.residual, finer * noise.weight)
    close = np.minimum(found.at - low, high - found.at) < 1e-3 * np.minimum(1.0, (high - low) / OFFSET)
    return Refined(
        free=free,
        scaled=found.at,
        deviation=np.hypot(deviation, found.rough),
        systematic=systematic,
        residual=found.residual,
        jacobian=exact,
        weight=noise.weight,
        at_bound=tuple(name for name, stops in zip(free.names, close) if stops),
        status=found.reason,
    )


def deviations(
    data: Dataset, free: Parameterisation, jacobian: Array, residual: Array, finer: Array
) -> tuple[Array, Array]:
    """Standard deviations of the scaled parameters, and their part from the number of hinges, (p,) both.

    H^-1 (sum g g^T) H^-1 with scores g summed over windows and over whole recordings, within which residuals are
    correlated, or H^-1, whichever is largest; besides a share of what the extrapolated change `finer` moves, of the
    scaled parameter itself or as the root mean square over its kind: one may vanish by chance.
    """
    inverse = covariance(jacobian)
    score = jacobian * residual[:, None]
    variance = robust_variance(inverse, score, (data.windows, data.recording_of))
    moved = np.abs(inverse @ (jacobian.T @ np.nan_to_num(finer)))
    for kind in set(free.kinds):
        alike = np.array([other == kind for other in free.kinds])
        moved[alike] = np.maximum(moved[alike], np.sqrt(np.mean(moved[alike] ** 2)))
    systematic = SYSTEMATIC * moved
    return np.sqrt(variance + systematic**2), systematic
