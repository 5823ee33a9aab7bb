"""Whether held-out data tell by themselves that what an explanation predicts is there."""

from types import SimpleNamespace

import numpy as np
import pytest

from boom_mj.diagnosis.criteria import BOOM
from boom_mj.diagnosis.decision import held_out_loss, sure

WINDOWS, LENGTH = 30, 50
COUNT = WINDOWS * LENGTH
DATA = SimpleNamespace(
    held_out=np.ones(COUNT, bool), windows=np.repeat(range(WINDOWS), LENGTH), recording_of=np.zeros(COUNT, int)
)
MODEL = SimpleNamespace(data=DATA, criteria=BOOM, facts=SimpleNamespace(repeat_s=None))
NOISE = np.random.default_rng(1).standard_normal(COUNT)
SHAPE = np.sin(np.arange(COUNT) / 3)


def beyond_chance(as_built: np.ndarray, predicted: np.ndarray) -> bool:
    found = SimpleNamespace(model=MODEL, fit=SimpleNamespace(residual=as_built - predicted))
    return sure(as_built, found)  # type: ignore[arg-type]


def test_what_predicts_nothing_is_not_there() -> None:
    assert not beyond_chance(NOISE, 0 * SHAPE)


@pytest.mark.parametrize("size", [0.0, 0.02, 0.5])
def test_noise_and_what_is_there(size: float) -> None:
    assert beyond_chance(NOISE + size * SHAPE, 0.5 * SHAPE) == (size == 0.5)


def test_what_acts_now_and_then() -> None:
    """Friction at a few stops: how much is closed scatters from window to window, though no window leaves a doubt."""
    stops = 4 * SHAPE * np.isin(DATA.windows, [3, 11, 12])
    fall, error = held_out_loss(MODEL, NOISE, NOISE + stops)  # type: ignore[arg-type]
    assert fall < BOOM.sure_z * error
    assert beyond_chance(NOISE + stops, stops)


def test_a_model_error_that_is_another_in_every_window() -> None:
    signs = np.random.default_rng(2).choice([-1.0, 1.0], WINDOWS)[DATA.windows]
    assert not beyond_chance(NOISE + 2 * signs * SHAPE, 0.7 * SHAPE)
