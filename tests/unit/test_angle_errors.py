"""What stands behind the reading of an angle sensor with an error."""

import numpy as np
import pytest

from boom_mj.effects import AngleEffect, make_effect
from boom_mj.sensors import true_angles
from boom_mj.sensors.measure import angle_errors


@pytest.mark.parametrize("periods", [1.0, 4.0])
def test_an_angle_behind_a_reading_reads_so(periods: float) -> None:
    effect = make_effect(
        "joint_sensor_nonlinearity", {"joint": 3, "amplitude": 0.02, "periods": periods, "phase": -2.4}
    )
    assert isinstance(effect, AngleEffect)
    angles = np.linspace(-1.5, 1.5, 40)[:, None] * np.ones(5)
    reading = angles + angle_errors([effect], angles)
    assert np.abs(reading - angles)[:, 2].max() > 0.01
    assert np.array_equal(np.delete(reading, 2, axis=1), np.delete(angles, 2, axis=1))
    assert np.abs(true_angles([effect], reading) - angles).max() < 1e-7


def test_errors_of_one_joint_add_up_and_are_taken_away_together() -> None:
    wave = make_effect("joint_sensor_nonlinearity", {"joint": 2, "amplitude": 0.02, "periods": 2.0, "phase": 0.3})
    offset, other = (make_effect("joint_zero_offset", {"joint": k, "offset": 0.01}) for k in (2, 5))
    angles = np.linspace(-1.5, 1.5, 40)[:, None] * np.ones(5)
    effects = [wave, offset, other]
    reading = angles + angle_errors(effects, angles)
    assert reading[:, 1] - angles[:, 1] == pytest.approx(0.02 * np.sin(2 * angles[:, 1] + 0.3) + 0.01)
    assert np.abs(true_angles(effects, reading) - angles).max() < 1e-7
