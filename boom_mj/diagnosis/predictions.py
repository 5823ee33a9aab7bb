"""What sensors would have said, of the nominal machine and of the explained one."""

import numpy as np

from boom_mj.diagnosis.diagnose import Diagnosis
from boom_mj.diagnosis.linearisation import of_size
from boom_mj.effects import Effect

Array = np.ndarray


def estimated_nuisances(found: Diagnosis) -> tuple[Effect, ...]:
    """Nuisances as effects of the size that the diagnosis estimated, zero offsets first; none of the named causes."""
    model = found.best.model if found.best else found.model
    effects = found.best.fit.effects if found.best else ()
    estimate = model.posterior.estimate(model.residual(*model.predict([effects])))
    return of_size([t.conditional_on(effects) for t in model.nuisances], estimate)


def causes(found: Diagnosis) -> tuple[Effect, ...]:
    """The effects of the best explanation; none where there is none."""
    return found.best.fit.effects if found.best else ()


def explanation(found: Diagnosis) -> tuple[Effect, ...]:
    """Nuisances as they were estimated, and the effects of the best explanation."""
    return (*estimated_nuisances(found), *causes(found))


def simulated_recordings(found: Diagnosis, corrected: bool) -> list[dict[str, Array]]:
    """What every recording's sensors would have said, by signal, at its own times, (n, k) each.

    Args:
        corrected: of the best explanation, or of the nominal machine; both have the nuisances that were estimated.
    """
    effects = explanation(found) if corrected else estimated_nuisances(found)
    predictor, level = found.model.predictor, found.model.facts.fidelity.shown
    return [predictor.recorded(effects, level, index) for index in range(len(predictor.data.recordings))]
