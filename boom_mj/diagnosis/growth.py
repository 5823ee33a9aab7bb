"""How large causes are in every recording by itself: a crack that grows, concrete that enters the pipe."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from boom_mj.diagnosis.candidate import Candidate
from boom_mj.diagnosis.clock import Clock
from boom_mj.diagnosis.fitting import fit, refine_jointly
from boom_mj.diagnosis.linearisation import Linearisation
from boom_mj.diagnosis.scoring import Scored, deviations
from boom_mj.effects import Effect
from boom_mj.estimation.bootstrap import gap
from boom_mj.estimation.least_squares import OPTIONS
from boom_mj.estimation.linear import LinearPosterior
from boom_mj.estimation.noise import NoiseModel
from boom_mj.systems.predictor import Predictor

Array = np.ndarray


def fitted_alone(
    model: Linearisation,
    index: int,
    effects: Sequence[Effect],
    since_s: float = 0.0,
    changed: bool = True,
    clock: Clock | None = None,
) -> Scored:
    """Causes as large as one recording asks for, from a moment on.

    Args:
        model: of the machine as it was built.
        effects: where the fit starts; it may also start at nothing.
        changed: whether they matter there: nuisances count otherwise in a machine that has them, which is heavier.
    """
    here, candidate = _alone(model, index, since_s).conditional_on(tuple(effects)), Candidate(tuple(effects))
    found = fit(here, candidate, OPTIONS.sharp, [np.zeros(len(candidate.start))], clock)
    if changed:
        (left,) = here.residuals([found.effects])
        here, candidate = here.relinearised(found.effects, here.posterior.estimate(left)), Candidate(found.effects)
        if model.facts.oscillatory:
            here, found = refine_jointly(here, candidate)
        else:
            found = fit(here, candidate, OPTIONS.sharp, clock=clock)
    return Scored(found, here, gap(found.residual, here.data.train), float("nan"), deviations(here, found))


def _alone(model: Linearisation, index: int, since_s: float) -> Linearisation:
    """One recording of the machine as it was built, all of which trains."""
    data = replace(model.data.alone(index, since_s), first=lambda time, lasts: np.ones(time.shape, bool))
    rows = model.data.rows(index)
    noise = NoiseModel(data, np.where(data.used, model.noise.weight[rows], 0.0), model.noise.error[rows])
    return replace(
        model,
        predictor=Predictor(model.system, data),
        level=model.facts.fidelity.middle,
        base=model.base[rows],
        mean_error=model.mean_error[rows],
        posterior=LinearPosterior.of(noise, model.columns[rows]),
    )
