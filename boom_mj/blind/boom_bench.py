"""Cases of a boom."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Self

import numpy as np

from boom_mj.blind.bench import Bench
from boom_mj.blind.detectability import Detectability
from boom_mj.blind.plant import AS_BUILT, DAMPING, MASS, STIFFNESS, nuisances, true_plant
from boom_mj.blind.sampling import VISIBLE
from boom_mj.blind.task import readme
from boom_mj.blind.unlisted import UNLISTED
from boom_mj.effects import BOOM_SITES, Effect, Site
from boom_mj.effects.base import Cause
from boom_mj.logs import write_mcap
from boom_mj.machine import parse_machine
from boom_mj.sensors import record
from boom_mj.simulation import CATALOGUE, Experiment, run_experiment

MACHINE = "machine.toml"


@dataclass(frozen=True)
class Suite:
    """Experiments for training, and held out."""

    train: tuple[Experiment, ...]
    holdout: tuple[Experiment, ...]

    @classmethod
    def named(cls, train: Sequence[str], holdout: Sequence[str]) -> Self:
        """Experiments of the catalogue."""
        return cls(tuple(CATALOGUE[name] for name in train), tuple(CATALOGUE[name] for name in holdout))


SUITE = Suite.named(
    ("release_bow_vertical", "release_stretched_horizontal", "release_stretched_vertical", "slew_t", "sweep"),
    ("fold_in", "mixed", "release_bow_horizontal"),
)
"""What a case records: 350 s."""
SHORT = Suite.named(("release_bow_vertical", "mixed"), ("sweep",))
"""What a short case records: 150 s. Joints 1 to 3 move in both parts, as friction of a joint at rest shows nothing."""


@dataclass(frozen=True)
class BoomBench(Bench):
    """A boom by the text of its nominal machine's file, and what is recorded."""

    machine: str
    suite: Suite

    @property
    def files(self) -> Mapping[str, str]:
        return {MACHINE: self.machine}

    @property
    def sites(self) -> Sequence[Site]:
        return BOOM_SITES

    @property
    def unlisted(self) -> Mapping[str, type[Effect]]:
        return UNLISTED

    @property
    def visible(self) -> float:
        return VISIBLE

    @property
    def readme(self) -> str:
        return readme()

    def visibility(self, effects: Sequence[Effect]) -> float:
        return min(_eye(self.machine, part).visibility(effects) for part in (self.suite.train, self.suite.holdout))

    def alike(self, effect: Effect) -> list[Cause]:
        return []

    def individual(self, rng: np.random.Generator, as_built: bool) -> tuple[Effect, ...]:
        return nuisances(parse_machine(self.machine), rng, AS_BUILT if as_built else (STIFFNESS, MASS, DAMPING))

    def record(self, effects: Sequence[Effect], rng: np.random.Generator, folder: Path) -> None:
        plant = true_plant(parse_machine(self.machine), effects)
        logs = {e.name: record(run_experiment(plant, e), e, rng) for e in (*self.suite.train, *self.suite.holdout)}
        for part, experiments in (("train", self.suite.train), ("holdout", self.suite.holdout)):
            (folder / part).mkdir(parents=True, exist_ok=True)
            for experiment in experiments:
                write_mcap(logs[experiment.name], folder / part / f"{experiment.name}.mcap")


@cache
def _eye(machine: str, experiments: tuple[Experiment, ...]) -> Detectability:
    return Detectability(parse_machine(machine), experiments)
