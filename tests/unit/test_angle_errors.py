"""What stands behind the reading of an angle sensor with an error."""

import numpy as np
import pytest

from boom_mj.effects import AngleEffect, Parameter, Site, make_effect
from boom_mj.errors import EffectError
from boom_mj.recording import Recording, named_signal
from boom_mj.sensors import driving_angles, true_angles
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


def test_an_error_of_no_sensor_is_named() -> None:
    """Fits try such ones on their way; where the angle grows without end nothing could be simulated."""

    class Steep(AngleEffect):
        id = "steep"
        table = {"cube": Parameter("1/rad^2", 0.0, -10.0, 10.0, 1.0)}

        def error(self, angle: np.ndarray) -> np.ndarray:
            return self.values["cube"] * angle**3

    reading = np.linspace(-1.5, 1.5, 40)[:, None] * np.ones(5)
    steep, slight = (Steep(Site((("joint", 2),)), cube=cube) for cube in (9.0, 0.01))
    assert np.abs(true_angles([slight], reading) - reading).max() < 0.04
    with pytest.raises(EffectError, match="steep"):
        true_angles([steep], reading)


def test_a_sensors_error_is_taken_out_before_it_is_blunted_with_the_noise() -> None:
    """What drives the boom accelerates as the joint did, jolts included, where the command is logged."""
    wave = make_effect("joint_sensor_nonlinearity", {"joint": 1, "amplitude": 0.01, "periods": 6.0, "phase": 0.3})
    time, noise = np.arange(0, 30, 0.02), np.radians(0.005)
    path = 0.4 * np.maximum(0.0, np.sin(1.2 * time))[:, None] ** 3 * np.ones(5)
    rng = np.random.default_rng(0)
    reading = path + angle_errors([wave], path) + noise * rng.standard_normal(path.shape)
    said = {"joint/position": reading, "joint_command/position": path}
    log = Recording("log", "boom36", "", {name: named_signal(name, time, values) for name, values in said.items()})

    def missed(angles: np.ndarray) -> float:
        jolts = np.diff(angles - path, n=2, axis=0)[:, 0] / 0.02**2
        return float(np.sqrt(np.mean(jolts[20:-20] ** 2)))

    before = missed(driving_angles(log, noise, time, [wave]))
    afterwards = missed(true_angles([wave], driving_angles(log, noise, time)))
    assert before < 0.5 * afterwards
