"""Means over blocks of time and noise by differences, on numbers that a reader can add up."""

import numpy as np
import pytest

from boom_mj.estimation.blocks import block_means, own_noise, rounding_noise


def test_means_leave_out_what_is_missing() -> None:
    time = np.array([0.0, 0.1, 0.2, 0.3, 0.6])
    middles, count, mean = block_means(time, np.array([1.0, np.nan, 3.0, 7.0, np.nan]), 0.2)
    assert middles == pytest.approx([0.1, 0.3, 0.7])
    assert count.tolist() == [1, 2, 0]
    assert mean[:2].tolist() == [1.0, 5.0] and np.isnan(mean[2])


def test_a_sample_at_the_end_of_a_block_belongs_to_the_next_though_rounded() -> None:
    time = 0.1 * np.arange(7)  # 3 * 0.1 is more than 0.3, 0.1 * 6 as well
    assert block_means(time, np.arange(7.0), 0.3)[2].tolist() == [1.0, 4.0, 6.0]


def test_noise_is_what_scatters_and_not_what_moves() -> None:
    noise, time = np.random.default_rng(0).standard_normal(4000), np.arange(4000) / 100
    moving = 0.3 * noise + 50 * np.sin(time)
    moving[::7] = np.nan
    assert own_noise(moving) == pytest.approx(0.3, rel=0.1)


@pytest.mark.parametrize(("samples", "known"), [(13, False), (14, True)])
def test_of_few_samples_nothing_is_known(samples: int, known: bool) -> None:
    assert (own_noise(np.random.default_rng(0).standard_normal(samples)) > 0) == known


def test_rounding_is_averaged_by_the_values_that_samples_have_only() -> None:
    step, rate, rng = 0.5, 100, np.random.default_rng(2)
    time = np.arange(4000) / rate
    rest = np.full(2000, 0.3) + 0.001 * rng.standard_normal(2000)  # all on one step
    moving = 3.0 * np.sin(2 * np.pi * time[:2000])  # on many
    seen = step * np.round(np.concatenate([rest, moving]) / step)
    still, fast = np.split(rounding_noise(time, seen, 0.2), 2)
    assert still == pytest.approx(step / np.sqrt(12)) and fast.max() < 0.6 * still[0]  # three steps at least
    assert not rounding_noise(time, rng.standard_normal(4000), 0.2).any()


def test_of_a_channel_that_says_one_thing_the_resolution_is_unknown() -> None:
    assert rounding_noise(np.arange(10) / 10, np.full(10, 2.0), 0.2).tolist() == [0.0] * 5
    holes = np.array([0.0, np.nan] * 3 + [1.0, 1.0, 0.0, 0.0])
    assert rounding_noise(np.arange(10) / 10, holes, 0.2) == pytest.approx(1 / np.sqrt(12))
