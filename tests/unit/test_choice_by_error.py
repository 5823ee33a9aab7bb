"""Of explanations of an MJCF machine the simplest is chosen that is no worse than the best by a standard error."""

from dataclasses import dataclass, field
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from boom_mj.diagnosis.criteria import MJCF
from boom_mj.diagnosis.decision import choose, held_out_loss
from boom_mj.diagnosis.scoring import _hidden

WINDOWS = np.repeat(np.arange(40), 25)
ALL = np.ones(1000, bool)
DATA = SimpleNamespace(windows=WINDOWS, held_out=ALL, recording_of=WINDOWS // 20, channel_of=np.zeros(1000, int))
MODEL: Any = SimpleNamespace(criteria=MJCF, data=DATA, facts=SimpleNamespace(repeat_s=None))
NOISE = np.random.default_rng(1).normal(size=1000)


@dataclass(frozen=True)
class Explanation:
    """As `Scored`, of so many causes, that leaves so much."""

    causes: int
    residual: np.ndarray = field(repr=False)
    plausible: bool = True
    model: Any = field(default_factory=lambda: MODEL)

    @property
    def doubt(self) -> float:
        return 0.0 if self.plausible else -2 * float(np.log(MJCF.unlikely_gap))

    @property
    def held_out(self) -> float:
        return float(np.sqrt(np.mean(self.residual**2)))

    @property
    def gaps(self) -> tuple[float, float]:
        return self.held_out, self.held_out

    @property
    def fit(self) -> Any:
        return SimpleNamespace(effects=range(self.causes), scaled=range(self.causes), residual=self.residual)


def leaving(size: float, causes: int, seed: int = 0, **more: Any) -> Explanation:
    """Noise, and something of a size that has no pattern."""
    return Explanation(causes, NOISE + size * np.random.default_rng(seed).normal(size=1000), **more)


NOMINAL = (10.0, 10.0)


def test_a_second_cause_that_closes_a_twentieth_counts_when_it_is_sure() -> None:
    one = Explanation(1, 4.0 * NOISE)
    two = Explanation(2, 3.8 * NOISE)
    loss, error = held_out_loss(MODEL, two.residual, one.residual)
    assert loss > 5 * error
    assert choose([two, one], NOMINAL) is two  # type: ignore[list-item]


def test_a_second_cause_within_its_error_does_not() -> None:
    one, two = leaving(3.0, 1, 5), leaving(3.0, 2, 6)
    best, other = sorted((one, two), key=lambda j: j.held_out)
    loss, error = held_out_loss(MODEL, best.residual, other.residual)
    assert loss < error
    assert choose([best, other], NOMINAL) is one  # type: ignore[list-item]


@pytest.mark.parametrize(("better", "chosen"), [(2.5, "likely"), (1.0, "unlikely")])
def test_an_unlikely_size_must_leave_half_of_what_a_likely_one_leaves(better: float, chosen: str) -> None:
    likely, unlikely = leaving(4.0, 1, 5), leaving(better, 1, 6, plausible=False)
    found = choose([unlikely, likely], NOMINAL)  # type: ignore[list-item]
    assert found is {"likely": likely, "unlikely": unlikely}[chosen]


def test_the_worst_moments_do_not_outvote_all_others() -> None:
    """One window of forty that gets worse by more than all others get better."""
    one = 4.0 * NOISE
    two = np.where(WINDOWS == 7, 20.0, 3.0) * NOISE
    assert np.mean(two**2) > np.mean(one**2)
    assert choose([Explanation(1, one), best := Explanation(2, two)], NOMINAL) is best  # type: ignore[list-item]


def test_few_recordings_make_a_standard_error_no_smaller() -> None:
    """Where stretches are enough, what differs from one to the next counts; two are too few to tell."""
    one, two = leaving(3.0, 1, 5), leaving(2.5, 2, 6)
    by_window = held_out_loss(MODEL, two.residual, one.residual)
    many = SimpleNamespace(**{**vars(DATA), "recording_of": WINDOWS // 5})
    model: Any = SimpleNamespace(criteria=MJCF, data=many, facts=MODEL.facts)
    assert held_out_loss(model, two.residual, one.residual)[1] >= by_window[1]


def test_hidden_error_vanishes_at_the_floor_and_grows_with_what_is_left() -> None:
    """Of a column of ones, n entries a cluster, G clusters: variance (m^2 - 1) n / N = (m^2 - 1) / G."""
    columns, inverse, channel = np.ones((1000, 1)), np.array([[1e-3]]), np.zeros(1000, int)
    unit = NOISE / np.sqrt(np.mean(NOISE**2))
    assert _hidden(inverse, columns, unit, channel, WINDOWS) == pytest.approx(0.0, abs=1e-9)
    assert _hidden(inverse, columns, 3 * unit, channel, WINDOWS) == pytest.approx((9 - 1) / 40)
