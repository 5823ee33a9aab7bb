"""What the boom lacks by its hinges and by its step, each refined apart, against eight hinges in steps of 1.25 ms."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from boom_mj.diagnosis.linearisation import linearise
from boom_mj.logs import read_log
from boom_mj.machine import load_machine
from boom_mj.recording import window
from boom_mj.systems.boom import BoomSystem
from boom_mj.systems.fidelity import Level
from boom_mj.systems.predictor import Predictor, dataset_of

ROOT = Path(__file__).parents[2]
SAME = 0.25  # of what is missing: an eighth of the step is left in the finest, and four hinges lack a little


def test_what_is_missing_is_told_by_checks_apart():
    log = read_log(ROOT / "logs" / "independent_release_stretched_vertical.mcap")
    short = replace(log, signals={name: window(signal, 0.0, 12.0) for name, signal in log.signals.items()})
    system = BoomSystem(load_machine(ROOT / "models" / "boom36.toml"))
    predictor = Predictor(system, dataset_of(system, [short], 1))
    middle, finest = (predictor.predict([()], level)[0] for level in (system.facts.fidelity.middle, Level(0.25, 8)))
    missing = linearise(predictor).mean_error
    lacks = finest - middle  # an eighth of the step's error is left in the finest
    used, noise = predictor.data.used, predictor.data.noise
    size, miss = (np.sqrt(np.mean((v[used] / noise[used]) ** 2)) for v in (lacks, missing - lacks))
    assert miss < SAME * size
