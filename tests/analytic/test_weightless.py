"""A boom without weight and load rests straight, exactly: Newton's method takes a step of zero there."""

from pathlib import Path

import numpy as np
import pytest

from boom_mj.machine import load_machine
from boom_mj.simulation import make_plant

BOOM = load_machine(Path(__file__).parents[2] / "models" / "boom36.toml").model_copy(update={"gravity": 0.0})


@pytest.mark.parametrize("hinges", [1, 4])
def test_it_rests_straight(hinges: int) -> None:
    plant, joints = make_plant(BOOM, hinges), np.radians([10.0, 60.0, -35.0, -40.0, -45.0])
    rest = plant.static_equilibrium(joints)
    assert rest[plant.joints] == pytest.approx(joints)
    assert np.all(rest[plant.elastic] == 0)
