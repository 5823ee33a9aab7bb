"""The smooth motion behind noisy joint angles, as good as a twin needs it."""

import numpy as np
import pytest
from scipy.signal import butter, sosfiltfilt

from boom_mj.simulation import CATALOGUE, smooth_angles
from boom_mj.simulation.smoothing import white_noise

NOISE = np.radians(0.02)
FINE = 0.005  # s


def shaking(name: str, rate: float, noise: float, told: float) -> np.ndarray:
    """Error of the accelerations below 1.5 Hz, rms of the joints that move, deg/s^2."""
    experiment, rng = CATALOGUE[name], np.random.default_rng(3)
    time, fine = np.arange(0, experiment.duration, 1 / rate), np.arange(0, experiment.duration - 0.1, FINE)
    angles, (true, _, acceleration) = experiment.joint_path(time)[0], experiment.joint_path(fine)
    smooth = smooth_angles(time, angles + noise * rng.normal(size=angles.shape), told, fine)
    error = np.gradient(np.gradient(smooth, FINE, axis=0), FINE, axis=0) - acceleration
    slow = sosfiltfilt(butter(2, 1.5, fs=1 / FINE, output="sos"), error[:, np.ptp(true, axis=0) > 0], axis=0)
    return np.degrees(np.sqrt(np.mean(slow**2)))


@pytest.mark.parametrize(("name", "bound"), [("slew_t", 0.045), ("mixed", 0.045), ("fold_in", 0.025), ("sweep", 0.08)])
def test_accelerations(name: str, bound: float) -> None:
    """Half above what seeds give; an even weight (Whittaker's smoother) is at 0.054, 0.04, 0.024 and 0.1."""
    assert shaking(name, 50, NOISE, NOISE) < bound


@pytest.mark.parametrize("rate", [15, 25, 100, 200])
def test_other_rates(rate: float) -> None:
    assert shaking("mixed", rate, NOISE, NOISE) < 0.06


def test_more_samples_say_more() -> None:
    errors = [shaking("mixed", rate, NOISE, NOISE) for rate in (25, 100, 400)]
    assert errors[0] > 1.3 * errors[1] > 1.3**2 * errors[2]


def test_noisier_sensors_than_the_machine_file_says() -> None:
    assert shaking("mixed", 50, 2 * NOISE, NOISE) < 1.2 * shaking("mixed", 50, 2 * NOISE, 2 * NOISE)


def test_rest_is_held_at_its_mean() -> None:
    time = np.arange(0, 30, 0.02)
    read = 0.7 + NOISE * np.random.default_rng(0).normal(size=(time.size, 1))
    smooth = smooth_angles(time, read, NOISE, time)
    np.testing.assert_allclose(smooth, read.mean(), atol=1e-9)


def test_an_error_that_creeps_while_the_joint_turns_is_no_stair() -> None:
    time = np.arange(0, 45, 0.02)
    error = 0.01 * np.sin(2.4 * 0.05 * time)[:, None]  # rad; slower than any window tells
    smooth = smooth_angles(time, error + NOISE * np.random.default_rng(3).normal(size=error.shape), NOISE, time)
    assert np.sqrt(np.mean((smooth - error) ** 2)) < NOISE / 3


def test_samples_need_not_be_even() -> None:
    rng = np.random.default_rng(1)
    time = np.sort(rng.uniform(0, 10, 600))
    angle = 0.1 * np.sin(0.5 * time)[:, None]
    smooth = smooth_angles(time, angle + NOISE * rng.normal(size=angle.shape), NOISE, time)
    assert np.sqrt(np.mean((smooth - angle) ** 2)) < NOISE / 3


def test_white_noise_under_motion() -> None:
    time = np.arange(0, 60, 0.02)
    angles = CATALOGUE["mixed"].joint_path(time)[0]
    read = angles + NOISE * np.random.default_rng(2).normal(size=angles.shape)
    np.testing.assert_allclose(white_noise(read), NOISE, rtol=0.08)  # three standard errors of a median of 3000


def test_an_error_that_grows_moves_the_angle_without_a_jump() -> None:
    """Where a fit asks what a little more of an error does, whether the joint rests must not be decided anew."""
    time = np.arange(0, 45, 0.02)
    shape = np.sin(2.4 * 0.05 * time)[:, None]
    noise, sizes = NOISE * np.random.default_rng(3).normal(size=shape.shape), NOISE * np.arange(100) / 100
    found = [smooth_angles(time, noise + size * shape, NOISE, time) for size in sizes]
    assert np.ptp(found[0]) < 1e-9 and np.std(found[-1] - sizes[-1] * shape) < NOISE / 5
    assert np.max(np.abs(np.diff(found, axis=0))) < 5 * sizes[1]
