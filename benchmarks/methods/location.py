"""Location alone: the effect whose gap would lie where this one lies, by sensor, link and direction.

    python benchmarks/methods/location.py cases -o answers

The power of the training residual above the noise, by channel group, is a distribution p; that of every effect at every
place, simulated at a typical size, is q. The effect of the largest overlap sum sqrt(p q) is named, without a size.
Nothing is wrong where the training gap is no larger than healthy machines have.
"""

import numpy as np
from cases import Answer, Case, answer_all, parser

from boom_mj.diagnosis.candidate import everywhere
from boom_mj.diagnosis.linearisation import linearise
from boom_mj.diagnosis.lines import spectral_lines
from boom_mj.diagnosis.screening import Screening
from boom_mj.estimation.bootstrap import gap

Array = np.ndarray


def solve(case: Case) -> Answer:
    """The effect of a case."""
    model = linearise(case.predictor())
    data, train = model.data, model.data.train
    residual = model.clean(model.residual(model.base))
    if gap(residual, train) <= model.criteria.healthy_gap:
        return {"verdict": "consistent", "effects": []}
    names = [channel.group for channel in data.channels]
    group = np.unique(names, return_inverse=True)[1][data.channel_of[train]]
    here = _shares(np.maximum(np.bincount(group, residual[train] ** 2) - np.bincount(group), 0.0))
    screening = Screening(model, everywhere(case.system, case.without), spectral_lines(model, residual))
    basis, overlap = model.posterior.trained, []
    for part in screening.stretches:
        columns = screening.columns[:, part]
        rest = columns - basis @ np.linalg.solve(model.posterior.basis.curvature, basis.T @ columns)
        powers = [np.bincount(group, column**2) for column in rest.T]
        overlap.append(max(float(np.sqrt(here * _shares(power)).sum()) for power in powers))
    kind, site, _ = screening.rows[int(np.argmax(overlap))]
    return {"verdict": "explained", "effects": [{"id": kind.id, "location": site.location}]}


def _shares(power: Array) -> Array:
    return power / max(power.sum(), 1e-300)


if __name__ == "__main__":
    given = parser(__doc__).parse_args()
    answer_all(given.cases, given.output, solve)
