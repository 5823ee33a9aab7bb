"""What a residual looks like, on a machine of two sensors."""

from collections.abc import Callable

import numpy as np
from algebra import model, swing
from pytest import approx, fixture, mark

from boom_mj.diagnosis.linearisation import Linearisation
from boom_mj.diagnosis.localisation import locate, looks_like

Array = np.ndarray


@fixture(scope="module")
def healthy() -> Linearisation:
    return model(())


def speed(time: Array) -> Array:
    return np.gradient(swing(time), time)


@mark.parametrize(
    ("shape", "look"),
    [
        (lambda time: np.sin(2 * np.pi * 0.9 * time), "periodic"),
        (lambda time: np.sign(speed(time)), "odd in velocity"),
        (lambda time: time - time.mean(), "drifting"),
        (np.ones_like, "pose dependent"),
        (lambda time: (time % 7 < 0.15).astype(float), "one-sided"),
    ],
)
def test_a_residual_looks_like_what_takes_most_of_it(
    healthy: Linearisation, shape: Callable[[Array], Array], look: str
) -> None:
    parts = []
    for channel in healthy.data.channels:  # of the swing, but not of the sweep after it
        seen = shape(channel.time) if channel.recording == 0 else np.zeros_like(channel.time)
        parts.append(seen)
    found, _, share = looks_like(healthy, np.concatenate(parts)).partition(" (")
    assert found == look and int(share.partition("%")[0]) > 30


def test_noise_looks_like_nothing_in_particular(healthy: Linearisation) -> None:
    noise = np.random.default_rng(0).standard_normal(len(healthy.base))
    assert looks_like(healthy, noise) == "nothing in particular"


def test_nothing_looks_like_nothing(healthy: Linearisation) -> None:
    assert looks_like(healthy, np.zeros(len(healthy.base))) == "nothing in particular"


def test_entries_that_do_not_train_have_no_residual_in_training(healthy: Linearisation) -> None:
    (left,) = healthy.residuals([()])
    assert not left[~healthy.data.train].any() and np.all(left[healthy.data.train] != 0)


def test_power_is_where_it_is(healthy: Linearisation) -> None:
    """A hum of the second sensor, while it moves: all of it there and above the static band, in proportion to time."""
    data = healthy.data
    hum = [
        np.sin(2 * np.pi * 0.9 * c.time) * (c.recording == 0) * (data.channels[k].signal == "second")
        for k, c in enumerate(data.channels)
    ]
    cells = locate(healthy, np.concatenate(hum))
    first = cells[0]
    assert (first.link, first.band, first.phase) == ("second", "above", "motion")
    assert first.share > 0.999 and sum(cell.share for cell in cells) == approx(1)
    assert first.gap == approx(0.5, rel=0.01)  # 1 / sqrt(2) in one of two logs
