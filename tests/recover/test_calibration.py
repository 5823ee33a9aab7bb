"""Planted parameters come back inside their intervals; plans ask for what recordings lack.

The machine that is measured has six hinges per coordinate, zero offsets and noise; the calibration works with four.
Experiments are shortened to 12 s, so that they run in seconds; the whole campaign is scripts/calibration.py.
"""

from functools import cache
from pathlib import Path

import numpy as np
import pytest

from boom_mj.calibration import Calibration, calibrate, calibrated_text, document, plan_next, validate
from boom_mj.calibration.parameters import make_space
from boom_mj.logs import read_log
from boom_mj.machine import load_machine, parse_machine
from boom_mj.recording import Recording
from boom_mj.sensors import record
from boom_mj.simulation import CATALOGUE, Experiment, make_plant, run_experiment

FILE = Path(__file__).parents[2] / "models" / "boom36.toml"
EXAMPLES = Path(__file__).parents[3] / "shared" / "examples" / "b18334f3fc04"
BOOM = load_machine(FILE)
KINDS = ("mass", "youngs_modulus_y", "damping")
FACTORS = {"mass": (1.06, 0.95, 1.08, 0.94), "youngs_modulus_y": (0.85, 1.15, 0.9, 1.12), "damping": (1.7,)}
OFFSETS = (0.004, -0.003, 0.002, 0.004, -0.005)


def short(name: str) -> Experiment:
    return CATALOGUE[name].model_copy(update={"duration": 12.0, "release": 2.5})


VERTICAL = (short("release_stretched_vertical"), short("release_bow_vertical"))


@cache
def recordings() -> tuple[Recording, ...]:
    truth = make_space(BOOM, KINDS).at(np.array([*np.log([f for kind in KINDS for f in FACTORS[kind]]), *OFFSETS]))
    plant = make_plant(truth.machine, 6, [truth.sensor])
    return tuple(record(run_experiment(plant, e), e, np.random.default_rng(k)) for k, e in enumerate(VERTICAL))


@cache
def calibration() -> Calibration:
    return calibrate(BOOM, recordings(), KINDS)


def test_planted_parameters_come_back() -> None:
    """Goals of the project: 1 % of masses and stiffness, 5 % of damping; two short recordings tell half as well."""
    answer = document(calibration(), ())
    told = [p for p in answer["parameters"] if not p["held"] and not p["with"]]
    assert len(told) >= 7, answer["sentence"]
    inside = 0
    for p in told:
        kind = p["name"].rpartition(".")[2]
        truth = FACTORS[kind][int(p["name"][4]) - 2] if kind != "damping" else FACTORS[kind][0]
        assert p["factor"] == pytest.approx(truth, rel=0.05 if kind == "damping" else 0.02), p["name"]
        inside += p["low"] <= truth * p["file"] <= p["high"]
    assert inside >= len(told) - 1  # of 95 % intervals one in twenty may miss
    for offset, true in zip(answer["zero_offsets_deg"][1:], OFFSETS[1:]):
        assert offset["value"] == pytest.approx(np.degrees(true), abs=0.03)
    assert answer["gap"]["before"] > 5 and answer["gap"]["after"] < 1.05  # floor 1


def test_the_twin_meets_what_was_measured() -> None:
    shown = validate(calibration())
    assert [row.direction for row in shown.comparisons] == ["vertical", "vertical"]
    for row in shown.comparisons:
        assert abs(row.fall[2] / row.fall[0] - 1) < 0.01 < abs(row.fall[1] / row.fall[0] - 1)
        assert abs(row.frequency[2] / row.frequency[0] - 1) < 0.005 < abs(row.frequency[1] / row.frequency[0] - 1)


def test_the_file_keeps_its_words() -> None:
    before, after = FILE.read_text().splitlines(), calibrated_text(FILE.read_text(), calibration()).splitlines()
    changed = [(old, new) for old, new in zip(before, after) if old != new]
    assert len(changed) == sum(abs(x) > 0 for x in calibration().coordinates[:-5])
    for old, new in changed:
        assert old.partition("=")[0] == new.partition("=")[0] and old.partition("#")[2] == new.partition("#")[2]
    made = parse_machine("\n".join(after))
    assert made.links[0].mass == pytest.approx(calibration().setting.machine.links[0].mass, rel=1e-5)
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
    # the 0.1 s in which the rope parts, and viscous friction that this machine lacks: docs/calibration.md
    assert over <= {("release_bow_horizontal", "imu/link5/specific_force/z"), ("fold_in", "cylinder3")}
