"""Which experiment to record next: the one that would tighten the least certain parameter most.

With the information H = J^T J of the recordings that there are (whitened sensitivities J at the machine file's values)
an experiment that adds H_e leaves the variances diag (H + H_e)^-1.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from threadpoolctl import threadpool_limits

from boom_mj.calibration.evidence import COARSE, model_error, predictor_of
from boom_mj.calibration.identify import NULL, inverse
from boom_mj.calibration.parameters import USUAL, Parameterisation, Variant, make_parameterisation
from boom_mj.calibration.refine import sensitivities
from boom_mj.errors import BoomError, LogError
from boom_mj.machine import Machine
from boom_mj.recording import Recording
from boom_mj.sensors import record
from boom_mj.simulation import CATALOGUE, Experiment, make_plant, run_experiment

Array = np.ndarray
LONGEST = 125.0  # s, of an experiment that is proposed


@dataclass(frozen=True)
class Proposal:
    """An experiment, and what it would make of the worst parameter.

    Attributes:
        after: standard deviation of the parameter's logarithm.
    """

    experiment: str
    duration: float
    after: float


@dataclass(frozen=True)
class Plan:
    """What to record next.

    Attributes:
        parameter: the least certain one that an experiment of the catalogue can tell.
        before: standard deviation of its logarithm from the recordings that there are.
        proposals: best first.
        untold: parameters that neither recordings nor catalogue inform of.
    """

    parameter: str
    before: float
    proposals: tuple[Proposal, ...]
    untold: tuple[str, ...]

    @property
    def sentence(self) -> str:
        """What to record next, in words."""
        best = self.proposals[0]
        known = f"known to {_percent(self.before)}" if self.before < NULL else "not told by these logs"
        text = f"{best.experiment}: {self.parameter}, {known}, would be known to {_percent(best.after)}"
        if self.untold:
            text += f". Nothing of the catalogue tells {', '.join(self.untold)}"
        return f"{text}."


def plan_next(
    machine: Machine,
    recordings: Sequence[Recording],
    kinds: Sequence[str] = USUAL,
    catalogue: Sequence[Experiment] = tuple(CATALOGUE.values()),
    threads: int | None = None,
    tell: Callable[[str], None] = lambda line: None,
) -> Plan:
    """Rank the experiments that were not recorded yet.

    Args:
        kinds: parameters that shall be identified.
        catalogue: to choose from.

    Raises:
        LogError: everything that the machine can do and that is short enough was recorded.
    """
    with threadpool_limits(1):
        free, done = make_parameterisation(machine, kinds), {log.name for log in recordings}
        have = _information(machine, recordings, free, threads)
        tell(f"information of {len(recordings)} recordings")
        found: dict[Experiment, Array] = {}
        for experiment in catalogue:
            if experiment.name in done or experiment.duration > LONGEST:
                continue
            try:
                log = record(run_experiment(make_plant(machine, COARSE.hinges), experiment), experiment)
                found[experiment] = have + _information(machine, [log], free, threads)
            except BoomError as error:
                tell(f"{experiment.name} cannot be: {error}")
                continue
            tell(f"information of {experiment.name}")
    if not found:
        raise LogError("there is nothing left to record: every experiment of the catalogue is there")
    before = _deviations(have, free)
    after = {experiment: _deviations(information, free) for experiment, information in found.items()}
    best = np.min(list(after.values()), axis=0)
    untold = best > NULL
    worst = int(np.argmax(np.where(untold, -1.0, before)))
    ranked = sorted(after, key=lambda experiment: after[experiment][worst])
    return Plan(
        parameter=free.names[worst],
        before=float(before[worst]),
        proposals=tuple(Proposal(e.name, e.duration, float(after[e][worst])) for e in ranked),
        untold=tuple(name for name, lost in zip(free.names, untold) if lost),
    )


def _information(
    machine: Machine, recordings: Sequence[Recording], free: Parameterisation, threads: int | None
) -> Array:
    """J^T J of recordings about the machine file's values, (size, size)."""
    predictor = predictor_of(machine, recordings, threads)
    jacobian = sensitivities(predictor, free, np.zeros(free.size), model_error(predictor, Variant(machine))[1])
    return jacobian.T @ jacobian


def _deviations(information: Array, free: Parameterisation) -> Array:
    """Of the parameters, zero offsets following freely, (tied,)."""
    return np.sqrt(np.diag(inverse(information)))[: len(free.tied)]


def _percent(deviation: float) -> str:
    return f"{100 * deviation:.2g} %"
