"""Planted parameters come back inside their intervals; plans ask for what recordings lack.

The machine that is measured has six hinges per elastic coordinate, zero offsets and noise; the calibration works with
four. Experiments are shortened to 12 s, so that they run in seconds; the whole campaign is scripts/calibration.py. Of
three machines the first is written down, the others are drawn.
"""

from functools import cache
from pathlib import Path

import numpy as np
import pytest

from boom_mj.calibration import Calibration, calibrate, calibrated_text, document, plan_next, validate
from boom_mj.calibration.parameters import make_parameterisation
from boom_mj.logs import read_log
from boom_mj.machine import load_machine, parse_machine
from boom_mj.recording import Recording
from boom_mj.sensors import record
from boom_mj.simulation import CATALOGUE, Experiment, make_plant, run_experiment

FILE = Path(__file__).parents[2] / "models" / "boom36.toml"
EXAMPLES = Path(__file__).parents[3] / "shared" / "examples" / "b18334f3fc04"
BOOM = load_machine(FILE)
KINDS = ("mass", "youngs_modulus_y", "damping")
SPREAD = {"mass": 0.1, "youngs_modulus_y": 0.2}  # half widths of drawn factors about 1
FACTORS = (1.06, 0.95, 1.08, 0.94, 0.85, 1.15, 0.9, 1.12, 1.7)
OFFSETS = (0.004, -0.003, 0.002, 0.004, -0.005)
FREE = make_parameterisation(BOOM, KINDS)
MACHINES = range(3)


def short(name: str) -> Experiment:
    return CATALOGUE[name].model_copy(update={"duration": 12.0, "release": 2.5})


VERTICAL = (short("release_stretched_vertical"), short("release_bow_vertical"))


@cache
def truth(number: int) -> np.ndarray:
    """Logarithms of factors, and zero offsets, rad, (14,)."""
    if number == 0:
        return np.array([*np.log(FACTORS), *OFFSETS])
    rng = np.random.default_rng(number)
    factors = [
        rng.uniform(0.5, 2.0) if k.kind == "damping" else 1 + SPREAD[k.kind] * rng.uniform(-1, 1) for k in FREE.tied
    ]
    return np.array([*np.log(factors), *rng.uniform(-0.005, 0.005, 5)])


@cache
def recordings(number: int = 0) -> tuple[Recording, ...]:
    variant = FREE.at(truth(number))
    plant = make_plant(variant.machine, 6, variant.sensor)
    return tuple(
        record(run_experiment(plant, e), e, np.random.default_rng(2 * number + k)) for k, e in enumerate(VERTICAL)
    )


@cache
def calibration(number: int = 0) -> Calibration:
    return calibrate(BOOM, recordings(number), KINDS)


@pytest.mark.parametrize("number", MACHINES)
def test_planted_parameters_come_back(number: int) -> None:
    """Goals of the project: 1 % of masses and stiffness, 5 % of damping; two short recordings tell half as well."""
    found = calibration(number)
    answer = document(found, ())
    assert not any(p["held"] or p["with"] for p in answer["parameters"]), answer["sentence"]
    for group, x, y in zip(FREE.tied, found.scaled, truth(number)):
        assert np.exp(x) == pytest.approx(np.exp(y), rel=0.05 if group.kind == "damping" else 0.02), group.name
    assert found.scaled[-4:] == pytest.approx(truth(number)[-4:], abs=np.radians(0.03))
    assert answer["gap"]["before"] > 5 and answer["gap"]["after"] < 1.05  # floor 1


def test_intervals_hold_what_was_planted() -> None:
    """Of 27 intervals of 95 % more than three miss once in 23 times; of 85 % ones, more often than not."""
    missed = []
    for number in MACHINES:
        for name, p, y in zip(FREE.names, document(calibration(number), ())["parameters"], truth(number)):
            assert p["name"] == name
            if not p["low"] <= np.exp(y) * p["file"] <= p["high"]:
                missed.append((number, name))
    assert len(missed) <= 3, missed


def test_the_twin_meets_what_was_measured() -> None:
    shown = validate(calibration())
    assert [row.direction for row in shown.comparisons] == ["vertical", "vertical"]
    for row in shown.comparisons:
        assert abs(row.fall[2] / row.fall[0] - 1) < 0.01 < abs(row.fall[1] / row.fall[0] - 1)
        assert abs(row.frequency[2] / row.frequency[0] - 1) < 0.005 < abs(row.frequency[1] / row.frequency[0] - 1)


def test_the_file_keeps_its_words() -> None:
    before, after = FILE.read_text().splitlines(), calibrated_text(FILE.read_text(), calibration()).splitlines()
    changed = [(old, new) for old, new in zip(before, after) if old != new]
    assert len(changed) == sum(abs(x) > 0 for x in calibration().scaled[:-5])
    for old, new in changed:
        assert old.partition("=")[0] == new.partition("=")[0] and old.partition("#")[2] == new.partition("#")[2]
    made = parse_machine("\n".join(after))
    assert made.links[0].mass == pytest.approx(calibration().variant.machine.links[0].mass, rel=1e-5)
    assert made.effect[0].id == "joint_zero_offset"


def test_a_plan_asks_for_what_the_recordings_lack() -> None:
    """Vertical releases tell nothing of sideways bending: the sideways one of three experiments does."""
    choice = (short("release_stretched_vertical_half"), short("release_stretched_horizontal"), VERTICAL[0])
    plan = plan_next(BOOM, recordings()[:1], ("youngs_modulus_z",), choice)
    assert plan.parameter.endswith("youngs_modulus_z")
    assert [p.experiment for p in plan.proposals] == ["release_stretched_horizontal", "release_stretched_vertical_half"]
    assert plan.proposals[0].after < 0.1 * plan.proposals[1].after


@pytest.mark.slow
@pytest.mark.skipif(not EXAMPLES.is_dir(), reason="there are no logs of the independent machine in ../shared/examples")
def test_a_machine_of_another_engine() -> None:
    """Built of geometrically exact beams elsewhere: stationary differences, first frequencies, held-out groups."""
    train, held_out = ([read_log(p) for p in sorted((EXAMPLES / part).glob("*.mcap"))] for part in ("train", "holdout"))
    shown = validate(calibrate(BOOM, train), held_out)
    assert len(shown.comparisons) == 6
    for row in shown.comparisons:
        assert abs(row.frequency[2] / row.frequency[0] - 1) < 0.005, row.name
        assert not abs(row.fall[2] / row.fall[0] - 1) >= 0.01, row.name
    over = {
        (shown.logs[k].log.name, group.name)
        for k in range(shown.training, len(shown.logs))
        for group in shown.twins[k][1].groups
        if group.ratio > 1.5
    }
    # the 0.1 s in which the rope parts, and viscous friction that this machine lacks: docs/results/calibration.md
    assert over <= {("release_bow_horizontal", "imu/link5/specific_force/z"), ("fold_in", "cylinder3")}
