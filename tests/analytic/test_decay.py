"""A decay made of known modes gives them back, with intervals that mean something."""

import numpy as np
import pytest

from boom_mj.calibration.decay import fit_decay

TIME = np.arange(0, 20, 0.1)
FREQUENCY, RATIO = np.array([0.5, 1.8]), np.array([0.02, 0.07])
CONSTANT, AMPLITUDE = np.array([3.0, -1.0, 0.2]), np.array([[0.3, 0.05], [0.1, 0.1], [0.2, 0.0]])


def decay(noise: float, seed: int) -> np.ndarray:
    values = np.tile(CONSTANT, (len(TIME), 1))
    for k, (f, z) in enumerate(zip(FREQUENCY, RATIO)):
        omega = 2 * np.pi * f
        wave = np.exp(-z * omega * TIME) * np.cos(omega * np.sqrt(1 - z**2) * TIME + 0.4 * k)
        values = values + wave[:, None] * AMPLITUDE[:, k]
    return values + noise * np.random.default_rng(seed).normal(size=values.shape)


def test_exact_modes_come_back_exactly() -> None:
    """From expectations that are 15 % off."""
    values = decay(0.0, 0)
    found = fit_decay(TIME, values, np.full(values.shape, 1e-3), 1.15 * FREQUENCY, 0.05)
    assert found.frequency == pytest.approx(FREQUENCY, rel=1e-6)
    assert found.damping_ratio == pytest.approx(RATIO, rel=1e-5)
    assert found.constant == pytest.approx(CONSTANT, abs=1e-7)
    assert found.share == pytest.approx(1, abs=1e-6)


def test_deviations_are_those_of_the_scatter() -> None:
    """Over 40 draws the scatter is what is told, within its own uncertainty of 1 / sqrt(80) and some."""
    fits = [fit_decay(TIME, v := decay(0.02, s), np.full(v.shape, 0.02), FREQUENCY, 0.02) for s in range(40)]
    for name, told in (("frequency", "frequency_deviation"), ("damping_ratio", "damping_deviation")):
        scatter = np.std(np.log([getattr(fit, name) for fit in fits]), axis=0)
        assert scatter == pytest.approx(np.mean([getattr(fit, told) for fit in fits], axis=0), rel=0.4)
    scatter = np.std([fit.constant for fit in fits], axis=0)
    assert scatter == pytest.approx(np.mean([fit.constant_deviation for fit in fits], axis=0), rel=0.4)


def test_noise_alone_has_no_vibration() -> None:
    values = np.random.default_rng(0).normal(size=(len(TIME), 20))
    assert fit_decay(TIME, values, np.ones(values.shape), FREQUENCY, 0.02).share < 0.1
