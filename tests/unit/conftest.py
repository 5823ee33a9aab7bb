"""What unit tests share."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from algebra import LIBRARY, Cube, Hum, Late, Offset, Ramp, Square, Term

from boom_mj.diagnosis import candidate
from boom_mj.diagnosis.criteria import BOOM
from boom_mj.diagnosis.linearisation import Linearisation
from boom_mj.estimation.linear import LinearPosterior
from boom_mj.estimation.noise import NoiseModel
from boom_mj.logs import read_log
from boom_mj.machine import load_machine
from boom_mj.recording import window
from boom_mj.systems.boom import BoomSystem
from boom_mj.systems.predictor import Predictor, dataset_of

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="session")
def model() -> Linearisation:
    """Two seconds of a release; model error and columns of nuisances are drawn."""
    log = read_log(ROOT / "logs" / "independent_release_stretched_vertical.mcap")
    cut = {name: window(signal, 7.0, 9.0) for name, signal in log.signals.items()}
    system = BoomSystem(load_machine(ROOT / "models" / "boom36.toml"))
    data, fidelity = dataset_of(system, [replace(log, signals=cut)], 1), system.facts.fidelity
    rng, nuisances = np.random.default_rng(0), system.nuisances()
    weight = np.where(data.used, 1 / data.noise, 0.0)
    error = 3 * rng.standard_normal(len(weight)) * data.noise
    columns = rng.standard_normal((len(weight), len(nuisances)))
    return Linearisation(
        Predictor(system, data, threads=1),
        effects=(),
        individual=(),
        level=fidelity.coarse,
        base=np.zeros(len(weight)),
        mean_error=error,
        posterior=LinearPosterior.of(NoiseModel(data, weight, fidelity.along * error), columns),
        nuisances=nuisances,
        all_nuisances=nuisances,
        criteria=BOOM,
    )


@pytest.fixture
def library(monkeypatch: pytest.MonkeyPatch) -> Callable[..., None]:
    """Lets only some effects compete."""

    def hold(*kinds: type[Term]) -> None:
        held = {name: kind for name, kind in LIBRARY.items() if kind in (Offset, *kinds)}
        monkeypatch.setattr(candidate, "effect_library", lambda: held)

    hold(Square, Cube, Ramp, Hum, Late)
    return hold
