"""The paper's three steps: masses from forces at rest, stiffness from falls and frequencies, damping from decay.

Each moves a few kinds of parameters until a few kinds of features fit, from the machine file on. The steps end near the
truth - masses lean on joint angles whose zero offsets only the second step tells -, and `refine` starts there.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from boom_mj.calibration.evidence import COARSE
from boom_mj.calibration.features import Features, Values
from boom_mj.calibration.parameters import STIFFNESS, Space

Array = np.ndarray
TRIALS = 3  # evaluations of a step, secants not counted
PRIOR, PRIOR_OFFSET = 0.2, 0.01  # deviations of a logarithm and of a zero offset, rad: what features do not tell stays


@dataclass(frozen=True)
class Step:
    """What moves, and what tells."""

    name: str
    moves: tuple[str, ...]
    told_by: tuple[str, ...]
    offsets: bool = False


STEPS = (
    Step("masses", ("mass", "center_of_gravity"), ("forces",)),
    Step("stiffness", STIFFNESS, ("falls", "frequencies", "places"), offsets=True),
    Step("damping", ("damping",), ("damping",)),
)


def approach(features: Features, space: Space, tell: Callable[[str], None] = lambda line: None) -> Array:
    """Coordinates near the truth, (space.size,); where nothing tells, those of the machine file.

    Args:
        tell: hears one line per step.
    """
    coordinates = np.zeros(space.size)
    correction = features.correction(space.at(coordinates))
    for step in STEPS:
        before = coordinates
        coordinates = _take(step, features, space, coordinates, correction)
        moved = np.exp(np.max(np.abs((coordinates - before)[: len(space.knobs)]), initial=0.0)) - 1
        tell(f"{step.name} by {', '.join(step.told_by)}: moved by {moved:.1%} at most")
    return coordinates


def _take(step: Step, features: Features, space: Space, start: Array, correction: Values) -> Array:
    free = [*space.subset(step.moves), *(range(len(space.knobs), space.size) if step.offsets else ())]
    measured = np.concatenate([features.measured[kind] for kind in step.told_by])
    deviation = np.concatenate([features.deviation[kind] for kind in step.told_by])
    seen = np.isfinite(measured)
    if not free or not seen.any():
        return start
    scale = np.where(np.array(free) < len(space.knobs), PRIOR, PRIOR_OFFSET)
    low, high = (bound[free] / scale for bound in space.bounds)

    def residual(shares: Array) -> Array:
        coordinates = start.copy()
        coordinates[free] = shares * scale
        model = features.of(space.at(coordinates), COARSE.hinges)
        found = np.concatenate([model[kind] + correction[kind] for kind in step.told_by])
        return np.concatenate([((measured - found) / deviation)[seen], shares])

    begin = np.clip(start[free] / scale, low, high)
    found = least_squares(
        residual, begin, bounds=(low, high), diff_step=1e-3, max_nfev=TRIALS, ftol=1e-3, x_scale="jac"
    )
    coordinates = start.copy()
    coordinates[free] = found.x * scale
    return coordinates
