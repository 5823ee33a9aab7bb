"""What stands behind the reading of an angle sensor with an error."""

import numpy as np
import pytest

from boom_mj.effects import AngleEffect, make_effect
from boom_mj.sensors import true_angles


@pytest.mark.parametrize("periods", [1.0, 4.0])
def test_an_angle_behind_a_reading_reads_so(periods: float) -> None:
    effect = make_effect(
        "joint_sensor_nonlinearity", {"joint": 3, "amplitude": 0.02, "periods": periods, "phase": -2.4}
    )
    assert isinstance(effect, AngleEffect)
    angles = np.linspace(-1.5, 1.5, 40)[:, None] * np.ones(5)
    reading = angles + effect.error(angles)
    assert np.abs(reading - angles)[:, 2].max() > 0.01
    assert np.abs(true_angles([effect], reading) - angles).max() < 1e-7
