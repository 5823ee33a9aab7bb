"""A second machine of the boom kind is accepted wherever the first is, and is another."""

from pathlib import Path

import numpy as np
import pytest

from boom_mj.cli import run
from boom_mj.machine import load_machine
from boom_mj.machine.linkages import cylinder2_length, cylinder3_length, moment_arm
from boom_mj.simulation import CATALOGUE
from boom_mj.simulation.agreement import compare_models, random_poses

BOOM24, BOOM36 = load_machine("boom24"), load_machine("boom36")


def test_it_is_another_boom() -> None:
    assert BOOM24.slewing.pivot_height + sum(link.length for link in BOOM24.links) == pytest.approx(24, abs=0.1)
    for small, large in zip(BOOM24.links, BOOM36.links):
        assert small.length < 0.7 * large.length and small.mass < 0.6 * large.mass and small.offset * large.offset < 0
    assert BOOM24.links[2].range_deg[1] > BOOM36.links[2].range_deg[1]


def test_its_cylinders_reach_and_push_everywhere() -> None:
    for length, link in ((cylinder2_length, BOOM24.links[0]), (cylinder3_length, BOOM24.links[1])):
        arms = moment_arm(length, BOOM24, np.linspace(*link.range, 50))
        assert np.all(np.isfinite(arms)) and np.abs(arms).min() > 0.2


@pytest.mark.parametrize("experiment", CATALOGUE.values(), ids=lambda experiment: experiment.name)
def test_it_performs_the_catalogue(experiment) -> None:
    experiment.check(BOOM24)


def test_its_model_is_that_of_the_reference() -> None:
    found = compare_models(BOOM24, 1, random_poses(BOOM24, 2, 0))
    assert np.abs(found.paper).max() < 0.04  # one hinge a coordinate; 0.028 is the worst of 20 poses


def test_commands_take_it(tmp_path: Path) -> None:
    assert run(["generate", "boom24", "-o", str(tmp_path / "b.xml")]) == 0
    assert run(["simulate", "boom24", "slew_t", "-o", str(tmp_path / "a.mcap")]) == 0
