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
from boom_mj.calibration.parameters import STIFFNESS, Parameterisation

Array = np.ndarray
TRIALS = 3  # evaluations of a step, secants not counted
PRIOR, PRIOR_OFFSET = 0.2, 0.01  # deviations of a logarithm and of a zero offset, rad: what features do not tell stays


@dataclass(frozen=True)
class Step:
    """What moves, and what tells."""

    name: str
    moves: tuple[str, ...]
    informed_by: tuple[str, ...]
    offsets: bool = False


STEPS = (
    Step("masses", ("mass", "center_of_gravity"), ("forces",)),
    Step("stiffness", STIFFNESS, ("falls", "frequencies", "places"), offsets=True),
    Step("damping", ("damping",), ("damping",)),
)


def initial_estimate(
    features: Features, free: Parameterisation, tell: Callable[[str], None] = lambda line: None
) -> Array:
    """Scaled parameters near the truth, (free.size,); where nothing tells, those of the machine file.

    Args:
        tell: hears one line per step.
    """
    scaled = np.zeros(free.size)
    correction = features.correction(free.at(scaled))
    for step in STEPS:
        before = scaled
        scaled = _take(step, features, free, scaled, correction)
        moved = np.exp(np.max(np.abs((scaled - before)[: len(free.tied)]), initial=0.0)) - 1
        tell(f"{step.name} by {', '.join(step.informed_by)}: moved by {moved:.1%} at most")
    return scaled


def _take(step: Step, features: Features, free: Parameterisation, start: Array, correction: Values) -> Array:
    moved = [*free.subset(step.moves), *(range(len(free.tied), free.size) if step.offsets else ())]
    measured = np.concatenate([features.measured[kind] for kind in step.informed_by])
    deviation = np.concatenate([features.deviation[kind] for kind in step.informed_by])
    seen = np.isfinite(measured)
    if not moved or not seen.any():
        return start
    scale = np.where(np.array(moved) < len(free.tied), PRIOR, PRIOR_OFFSET)
    low, high = (bound[moved] / scale for bound in free.bounds)

    def residual(shares: Array) -> Array:
        scaled = start.copy()
        scaled[moved] = shares * scale
        model = features.of(free.at(scaled), COARSE.hinges)
        found = np.concatenate([model[kind] + correction[kind] for kind in step.informed_by])
        return np.concatenate([((measured - found) / deviation)[seen], shares])

    begin = np.clip(start[moved] / scale, low, high)
    found = least_squares(
        residual, begin, bounds=(low, high), diff_step=1e-3, max_nfev=TRIALS, ftol=1e-3, x_scale="jac"
    )
    scaled = start.copy()
    scaled[moved] = found.x * scale
    return scaled
