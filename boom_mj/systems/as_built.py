"""A system as it was built: the nominal one with effects that it had when it was well."""

from collections.abc import Mapping, Sequence
from types import MappingProxyType

import numpy as np

from boom_mj.effects import Effect, Site, is_output
from boom_mj.estimation.dataset import Dataset
from boom_mj.recording import Recording, Signal
from boom_mj.systems.fidelity import Level
from boom_mj.systems.system import (
    NO_REASONS,
    ChannelPlace,
    Corrects,
    Designs,
    Hypothesis,
    LinearResponse,
    Nuisance,
    Reasons,
    ResidualForce,
    ResidualForces,
    System,
    SystemFacts,
    Timeline,
)

Array = np.ndarray


def nominal_system(system: System) -> System:
    """The machine as its file is, whatever is known of how it was built."""
    return system.system if isinstance(system, AsBuilt) else system


class AsBuilt:
    """Another system of which every hypothesis has some effects besides.

    Args:
        system: nominal.
        built: effects that it has.
        unsure: nuisances about these; those of the system if left out.
        deviations: standard deviations of their parameters, by cause and name, scaled.
    """

    def __init__(
        self,
        system: System,
        built: Hypothesis,
        unsure: tuple[Nuisance, ...] | None = None,
        deviations: Mapping[tuple[tuple, str], float] = MappingProxyType({}),
    ) -> None:
        self.system, self.built, self.deviations = system, built, deviations
        self._nuisances = system.nuisances() if unsure is None else unsure
        self._outputs = tuple(effect for effect in built if is_output(effect))
        self._simulated = tuple(effect for effect in built if not is_output(effect))

    @property
    def facts(self) -> SystemFacts:
        return self.system.facts

    def sites(self) -> tuple[Site, ...]:
        return self.system.sites()

    def nuisances(self) -> tuple[Nuisance, ...]:
        return self._nuisances

    def doubt(self, effect: Effect, name: str) -> float:
        """Of a change: where it is a ratio, as large a share of it as is unsure of what it multiplies."""
        deviation = self.deviations.get((effect.cause, name), 0.0)
        if not deviation or not effect.declared[name].ratio:
            return deviation
        own = next(one.values[name] for one in self.built if one.cause == effect.cause)
        return deviation * effect.values[name] / own

    def timeline(self, log: Recording) -> Timeline:
        return self.system.timeline(log)

    def simulate(self, hypothesis: Hypothesis, level: Level, log: Recording) -> dict[str, Signal]:
        return self.system.simulate((*self._simulated, *hypothesis), level, log)

    def observe(self, hypothesis: Hypothesis, dense: Mapping[str, Signal]) -> dict[str, Signal]:
        return self.system.observe((*self._outputs, *hypothesis), dense)

    def channel(self, signal: str, column: int) -> ChannelPlace:
        return self.system.channel(signal, column)

    def forces(self, data: Dataset, white: Array, weight: Array) -> tuple[ResidualForce, ...]:
        """Of the system, if its channels tell where it is."""
        return self.system.forces(data, white, weight) if isinstance(self.system, ResidualForces) else ()

    def next_experiment(self, rivals: Sequence[Hypothesis], done: Sequence[str]) -> str | None:
        """Of the system, if it knows its experiments."""
        return self.system.next_experiment(rivals, done) if isinstance(self.system, Designs) else None

    def corrected(self, causes: Hypothesis, nuisances: Hypothesis = (), reasons: Reasons = NO_REASONS) -> str:
        """Its file with effects in it; what it was built with is one of its nuisances."""
        assert isinstance(self.system, Corrects)
        return self.system.corrected(causes, nuisances, reasons)

    def column(self, effect: Effect, data: Dataset, nuisances: Array) -> Array | None:
        """Of the system, if it knows responses."""
        if not isinstance(self.system, LinearResponse):
            return None
        return self.system.column(effect, data, nuisances)
