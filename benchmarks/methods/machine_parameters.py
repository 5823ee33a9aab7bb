"""Identification: every parameter of the machine file is fitted, and the one farthest from its data sheet is the cause.

    python benchmarks/methods/machine_parameters.py cases -o answers

Masses and stiffness of all links, damping and viscous friction, by least squares on the training recordings, with zero
offsets of the joints as nuisances. A parameter's distance is its change over

    sqrt(standard error^2 + scatter^2)

with the scatter of healthy machines, which the task tells. Nothing is wrong where no distance exceeds what chance makes
of the largest in LEVEL of all cases. Loads and sensors have no parameter here; they are taken for something else.
"""

import numpy as np
from cases import Answer, Case, answer_all, cause_of, parser
from scipy.special import ndtri

from boom_mj.blind.plant import DAMPING, MASS, STIFFNESS
from boom_mj.diagnosis.candidate import Candidate, everywhere
from boom_mj.diagnosis.fitting import fit
from boom_mj.diagnosis.linearisation import linearise
from boom_mj.diagnosis.scoring import score
from boom_mj.systems.boom.nuisances import OFFSET

SCATTER = {"link_mass": MASS, "link_stiffness": STIFFNESS, "structural_damping": DAMPING, "viscous_friction": 0.0}
"""How far healthy machines are off, uniformly to either side, as shares."""
LEVEL = 0.05  # of a false alarm, all parameters together


def solve(case: Case) -> Answer:
    """The cause of a case."""
    offsets = tuple(n for n in case.system.nuisances() if n.hypothesis[0].id == OFFSET)
    model = linearise(case.predictor(), nuisances=offsets)
    sites = [(kind, site) for kind, site in everywhere(case.system, case.without) if kind.id in SCATTER]
    found = score(model, fit(model, Candidate(tuple(kind(site) for kind, site in sites))))
    kinds = [(found.fit.effects[owner].id, parameter) for owner, _, parameter in found.fit.candidate.parameters]
    scatter = np.array([SCATTER[name] / np.sqrt(3) / parameter.typical for name, parameter in kinds])
    distance = np.abs(found.fit.scaled) / np.hypot(found.deviation, scatter)
    farthest = -ndtri(LEVEL / 2 / len(distance))
    if distance.max() <= farthest:
        return {"verdict": "consistent", "effects": []}
    owner = found.fit.candidate.parameters[int(np.argmax(distance))][0]
    return {"verdict": "explained", "effects": [cause_of(found, owner)]}


if __name__ == "__main__":
    given = parser(__doc__).parse_args()
    answer_all(given.cases, given.output, solve)
