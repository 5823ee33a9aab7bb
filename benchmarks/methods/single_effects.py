"""Single effects: each is fitted alone on all data, and the Bayesian information criterion chooses.

    python benchmarks/methods/single_effects.py cases -o answers

Nothing is held out. Of the effects that screening ranks first, and of none at all, the one with the least

    BIC = sum of whitened squares + k log N

is named, k its parameters and N the block means of all recordings; the same sums give probabilities, exp(-BIC / 2) over
their total. Several effects, and effects that the library lacks, are never the answer.
"""

from dataclasses import replace

import numpy as np
from cases import Answer, Case, answer_all, cause_of, parser

from boom_mj.diagnosis.candidate import Candidate, everywhere
from boom_mj.diagnosis.fitting import fit
from boom_mj.diagnosis.linearisation import Linearisation, linearise
from boom_mj.diagnosis.lines import spectral_lines
from boom_mj.diagnosis.scoring import Scored, deviations
from boom_mj.diagnosis.screening import Screening

FITTED = 12  # of the candidates that screening ranks


def solve(case: Case, fitted: int = FITTED) -> Answer:
    """The single effect of a case."""
    everything = replace(case.data, training=len(case.data.recordings), first=lambda time, lasts: time >= 0)
    model = linearise(case.predictor(everything))
    raw = model.residual(model.base)
    left, estimate = model.posterior.left(raw)
    lines = spectral_lines(model, model.clean(raw))
    ranked = Screening(model, everywhere(case.system, case.without), lines).rank(raw)[:fitted]
    fits = [_fit(model, one.candidate) for one in ranked]
    sizes = [2 * one.fit.cost + len(one.fit.scaled) * np.log(len(left)) for one in fits]
    criteria = np.array([left @ left + estimate @ estimate, *sizes])
    likely = np.exp(-(criteria - criteria.min()) / 2)
    nothing, *alone = (float(share) for share in likely / likely.sum())
    best = int(np.argmin(criteria))
    answer = {"others": {"none": nothing, "outside_library": 0.0}, "effects": [], "verdict": "consistent"}
    if best == 0:
        return answer
    return {**answer, "verdict": "explained", "effects": [cause_of(fits[best - 1], 0, alone[best - 1])]}


def _fit(model: Linearisation, candidate: Candidate) -> Scored:
    own = model.conditional_on(candidate.effects)
    found = fit(own, candidate)
    return Scored(found, own, np.nan, np.nan, deviations(own, found))


if __name__ == "__main__":
    given = parser(__doc__).parse_args()
    answer_all(given.cases, given.output, solve)
