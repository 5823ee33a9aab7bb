"""The joint refinement: all recordings, all coordinates at once, by scipy's trust-region least squares.

Residuals are whitened: measured less predicted less what finer hinges would add, over noise and model error.
Predictions are of the middle level; sensitivities are secants of the coarse one, and stay while the coordinates do.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from boom_mj.calibration.evidence import COARSE, MIDDLE, predict
from boom_mj.calibration.identify import covariance
from boom_mj.calibration.parameters import OFFSET, Setting, Space
from boom_mj.estimation.bootstrap import gap
from boom_mj.estimation.dataset import Dataset
from boom_mj.estimation.intervals import robust_variance
from boom_mj.estimation.noise import NoiseModel
from boom_mj.systems.predictor import Predictor

Array = np.ndarray
NEAR = 0.05  # of a logarithm, within which sensitivities stay
EVALUATIONS = 15  # of the refinement
ENOUGH, ROUGH = 0.03, 3.0  # fall of the cost at which it ends: one deviation is a fall of 0.5
SYSTEMATIC = 0.3  # share of what the hinges' extrapolation moves that may be wrong, by machines of six hinges


@dataclass(frozen=True, eq=False)
class Refined:
    """Coordinates at their best, and how sure they are.

    Attributes:
        space: of the coordinates.
        coordinates: (p,).
        deviation: standard deviations, (p,).
        systematic: their part that comes from the number of hinges, (p,).
        residual: whitened, (N,).
        jacobian: whitened sensitivities, (N, p).
        weight: 1 / deviation of every entry, (N,).
        at_bound: names of coordinates that stopped at a bound.
        status: how the search ended.
    """

    space: Space
    coordinates: Array
    deviation: Array
    systematic: Array
    residual: Array
    jacobian: Array
    weight: Array
    at_bound: tuple[str, ...]
    status: str

    @property
    def setting(self) -> Setting:
        """The machine and the zero offsets."""
        return self.space.at(self.coordinates)

    def weighted(self, weight: Array) -> Array:
        """The sensitivities, whitened by another weight, (N, p)."""
        return self.jacobian * (weight / np.where(self.weight > 0, self.weight, 1.0))[:, None]


def sensitivities(predictor: Predictor, space: Space, coordinates: Array, noise: NoiseModel) -> Array:
    """Whitened d prediction / d coordinate, (N, size), by secants of the coarse level."""
    steps = np.where(coordinates + space.steps <= space.bounds[1], space.steps, -space.steps)
    points = [coordinates, *(coordinates + step * row for step, row in zip(steps, np.eye(space.size)))]
    base, *moved = predict(predictor, [space.at(point) for point in points], COARSE)
    return np.stack([np.nan_to_num((m - base) / step) * noise.weight for m, step in zip(moved, steps)], axis=1)


def refine(
    predictor: Predictor,
    space: Space,
    start: Array,
    error: tuple[Array, NoiseModel],
    jacobian: Array | None = None,
    enough: float = ENOUGH,
    tell: Callable[[str], None] = lambda line: None,
) -> Refined:
    """Fit all coordinates to all recordings.

    Args:
        start: coordinates, (p,).
        error: what finer hinges add, (N,), and the noise: `model_error` near there.
        jacobian: whitened sensitivities there, (N, p), where they are known.
        enough: fall of the cost at which it ends.
        tell: hears one line per prediction.
    """
    (finer, noise), data = error, predictor.data
    secants = _Secants(predictor, space, noise, start, jacobian)

    def residual(coordinates: Array) -> Array:
        (prediction,) = predict(predictor, [space.at(coordinates)], MIDDLE)
        white = noise.white(data.measured - prediction - finer)
        tell(f"gap {gap(white, data.used):.3f}")
        secants.hear(coordinates, white)
        return white

    low, high = space.bounds
    begin = np.clip(start, low + 1e-9, high - 1e-9)
    found = least_squares(
        residual,
        begin,
        lambda coordinates: -secants.at(coordinates),
        (low, high),
        x_scale="jac",
        ftol=2 * enough / np.count_nonzero(data.used),
        xtol=1e-7,
        gtol=None,
        max_nfev=EVALUATIONS,
    )
    jacobian = secants.exact
    deviation, systematic = deviations(data, space, jacobian, found.fun, finer * noise.weight)
    close = np.minimum(found.x - low, high - found.x) < 1e-3 * np.minimum(1.0, (high - low) / OFFSET)
    return Refined(
        space=space,
        coordinates=found.x,
        deviation=deviation,
        systematic=systematic,
        residual=found.fun,
        jacobian=jacobian,
        weight=noise.weight,
        at_bound=tuple(name for name, there in zip(space.names, close) if there),
        status=found.message,
    )


class _Secants:
    """Sensitivities that are taken anew where coordinates have moved far, and follow by Broyden's update where not."""

    def __init__(self, predictor: Predictor, space: Space, noise: NoiseModel, at: Array, known: Array | None):
        self._predictor, self._space, self._noise = predictor, space, noise
        self.exact = sensitivities(predictor, space, at, noise) if known is None else known
        self._at, self._updated = at, self.exact
        self._last: tuple[Array, Array] | None = None
        self._heard: tuple[Array, Array] | None = None

    def hear(self, coordinates: Array, residual: Array) -> None:
        """The residual at coordinates that were tried."""
        self._heard = coordinates.copy(), residual

    def at(self, coordinates: Array) -> Array:
        """d prediction / d coordinate at coordinates whose residual was heard last, (N, p)."""
        if np.max(np.abs(coordinates - self._at)) > NEAR:
            self.exact = self._updated = sensitivities(self._predictor, self._space, coordinates, self._noise)
            self._at = coordinates.copy()
        elif self._last is not None and self._heard is not None:
            moved = coordinates - self._last[0]
            scaled = moved * np.sum(self.exact**2, axis=0)
            miss = self._last[1] - self._heard[1] - self._updated @ moved
            self._updated = self._updated + np.outer(miss, scaled / max(float(scaled @ moved), 1e-300))
        self._last = self._heard
        return self._updated


def deviations(data: Dataset, space: Space, jacobian: Array, residual: Array, finer: Array) -> tuple[Array, Array]:
    """Standard deviations of the coordinates, and their part from the number of hinges, (p,) both.

    H^-1 (sum g g^T) H^-1 with scores g summed over windows and over whole recordings, within which residuals are
    correlated, or H^-1, whichever is largest; besides a share of what the extrapolated change `finer` moves, of the
    coordinate itself or as the root mean square over its kind: one may vanish by chance.
    """
    inverse = covariance(jacobian)
    score = jacobian * residual[:, None]
    variance = robust_variance(inverse, score, (data.windows, data.recording_of))
    moved = np.abs(inverse @ (jacobian.T @ np.nan_to_num(finer)))
    for kind in set(space.kinds):
        alike = np.array([other == kind for other in space.kinds])
        moved[alike] = np.maximum(moved[alike], np.sqrt(np.mean(moved[alike] ** 2)))
    systematic = SYSTEMATIC * moved
    return np.sqrt(variance + systematic**2), systematic
