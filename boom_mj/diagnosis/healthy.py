"""Healthy first: what recordings of a machine that was well say of how it was built, so that what changed is told.

No two machines are built alike: masses differ by 2 %, stiffness by 3 %, damping by 25 %. A boom's individual values are
estimated from healthy recordings by Gauss-Newton steps, with priors that wide, and what recordings leave unsure of them
are its nuisances from then on. Any other machine is diagnosed on its healthy recordings, and what explains them counts
as how it was built.
"""

from collections.abc import Sequence

import numpy as np
from threadpoolctl import threadpool_limits

from boom_mj.diagnosis.clock import Clock
from boom_mj.diagnosis.diagnose import diagnose
from boom_mj.diagnosis.linearisation import linearise, of_size
from boom_mj.estimation.bootstrap import gap
from boom_mj.recording import Recording
from boom_mj.systems.as_built import AsBuilt
from boom_mj.systems.predictor import Predictor, dataset_of
from boom_mj.systems.system import Individuals, Nuisance, System

Array = np.ndarray
ROUNDS = 3  # Gauss-Newton steps, each about the machine that the last has found


def as_built(system: System, healthy: Sequence[Recording], clock: Clock | None = None) -> AsBuilt:
    """The system with what healthy recordings say of it."""
    clock = clock or Clock()
    predictor = Predictor(system, dataset_of(system, healthy, len(healthy)))
    clock.tell(f"the machine as built, by {len(healthy)} healthy recordings")
    with threadpool_limits(1):
        if isinstance(system, Individuals):
            return _individual(predictor, system.individual(), clock)
        best = diagnose(predictor, clock=clock).best
    if best is None:
        return AsBuilt(system, ())
    effects, parameters = best.fit.effects, best.fit.candidate.parameters
    found = {(effects[k].cause, name): float(d) for (k, name, _), d in zip(parameters, best.deviation)}
    return AsBuilt(system, effects, deviations=found)


def _individual(predictor: Predictor, nuisances: tuple[Nuisance, ...], clock: Clock) -> AsBuilt:
    """With nuisances of the size that all recordings ask for."""
    model = linearise(predictor, nuisances=nuisances)
    for _ in range(ROUNDS):
        estimate = model.posterior.estimate(model.residual(model.base))
        left = gap(model.clean(model.residual(model.base)), model.data.used)
        clock.tell(f"as built, healthy gap {left:.2f}")
        if clock.over("the machine as built"):
            break
        model = model.relinearised((), estimate)
    estimate = model.posterior.estimate(model.residual(model.base))
    covariance = max(1.0, left) ** 2 * np.linalg.inv(model.posterior.basis.curvature)
    usual = predictor.system.nuisances()
    built, deviations = of_size(nuisances, estimate), _deviations(nuisances, covariance)
    return AsBuilt(predictor.system, built, _unsure(nuisances, usual, covariance), deviations)


def _deviations(nuisances: Sequence[Nuisance], covariance: Array) -> dict[tuple[tuple, str], float]:
    """Standard deviations of parameters by cause and name, scaled, of a covariance (m, m) in prior deviations."""
    slopes: dict[tuple[tuple, str], Array] = {}
    for k, nuisance in enumerate(nuisances):
        for effect in nuisance.hypothesis:
            for name, value in effect.values.items():
                slope = slopes.setdefault((effect.cause, name), np.zeros(len(nuisances)))
                slope[k] = nuisance.deviation * effect.declared[name].coordinate(value)
    return {key: float(np.sqrt(slope @ covariance @ slope)) for key, slope in slopes.items()}


def _unsure(wide: Sequence[Nuisance], usual: Sequence[Nuisance], covariance: Array) -> tuple[Nuisance, ...]:
    """Nuisances of a machine that recordings tell of: what may be set anew as usual, how it was built as they say.

    Those in which machines differ by more than usual are how it was built. The principal directions of their part of
    the covariance, (m, m) in prior deviations, know nothing of each other; each is several effects at once.
    """
    apart = np.array([one.deviation != other.deviation for one, other in zip(wide, usual)])
    own = [one for one, so in zip(wide, apart) if so]
    variance, turn = np.linalg.eigh(covariance[np.ix_(apart, apart)])
    found = [one for one, so in zip(usual, apart) if not so]
    for step in (turn * np.sqrt(np.minimum(variance, 1.0))).T:
        largest = max(abs(size) * one.deviation for size, one in zip(step, own))  # in steps of derivatives
        found.append(Nuisance(of_size(own, step / largest), largest))
    return tuple(found)
