"""Healthy first: what recordings of a machine that was well say of how it was built, so that what changed is told.

No two machines are built alike: masses differ by 2 %, stiffness by 3 %, damping by 25 %. A boom's individual values are
estimated from healthy recordings by Gauss-Newton steps, with priors that wide. Any other machine is diagnosed on its
healthy recordings, and what explains them counts as how it was built.
"""

from collections.abc import Sequence

from threadpoolctl import threadpool_limits

from boom_mj.diagnosis.clock import Clock
from boom_mj.diagnosis.diagnose import diagnose
from boom_mj.diagnosis.linearisation import linearise, of_size
from boom_mj.effects import Effect
from boom_mj.estimation.bootstrap import gap
from boom_mj.recording import Recording
from boom_mj.systems.as_built import AsBuilt
from boom_mj.systems.predictor import Predictor, dataset_of
from boom_mj.systems.system import Individuals, System

ROUNDS = 3  # Gauss-Newton steps, each about the machine that the last has found


def as_built(system: System, healthy: Sequence[Recording], clock: Clock | None = None) -> AsBuilt:
    """The system with what healthy recordings say of it."""
    clock = clock or Clock()
    predictor = Predictor(system, dataset_of(system, healthy, len(healthy)))
    clock.tell(f"the machine as built, by {len(healthy)} healthy recordings")
    with threadpool_limits(1):
        if isinstance(system, Individuals):
            return AsBuilt(system, _individual(predictor, system, clock))
        found = diagnose(predictor, clock=clock)
    return AsBuilt(system, found.best.fit.effects if found.best else ())


def _individual(predictor: Predictor, system: Individuals, clock: Clock) -> tuple[Effect, ...]:
    """Nuisances of the size that all recordings ask for."""
    nuisances = system.individual()
    model = linearise(predictor, nuisances=nuisances)
    for _ in range(ROUNDS):
        estimate = model.posterior.estimate(model.residual(model.base))
        left = gap(model.clean(model.residual(model.base)), model.data.used)
        clock.tell(f"as built, healthy gap {left:.2f}")
        if clock.over("the machine as built"):
            break
        model = model.relinearised((), estimate)
    return of_size(nuisances, model.posterior.estimate(model.residual(model.base)))
