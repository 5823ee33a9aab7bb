"""What unit tests share."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from boom_mj.diagnosis import Campaign
from boom_mj.diagnosis.linearisation import Metric
from boom_mj.logs import read_log
from boom_mj.machine import load_machine
from boom_mj.recording import window
from boom_mj.systems.boom.system import tolerances

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="session")
def metric() -> Metric:
    """Two seconds of a release; model error and columns of nuisances are drawn."""
    log = read_log(ROOT / "logs" / "independent_release_stretched_vertical.mcap")
    cut = {name: window(signal, 7.0, 9.0) for name, signal in log.signals.items()}
    campaign = Campaign(load_machine(ROOT / "models" / "boom36.toml"), [replace(log, signals=cut)], 1, threads=1)
    rng = np.random.default_rng(0)
    weight = np.where(campaign.used, 1 / campaign.noise, 0.0)
    error = 3 * rng.standard_normal(len(weight)) * campaign.noise
    columns = rng.standard_normal((len(weight), len(tolerances())))
    level, base = campaign.subject.fidelity.coarse, np.zeros(len(weight))
    return Metric(campaign, (), (), level, base, error, error, weight, columns, tolerances())
