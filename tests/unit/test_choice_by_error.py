"""Of explanations of an MJCF machine the simplest is chosen that is no worse than the best by a standard error."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from boom_mj.diagnosis import stages
from boom_mj.diagnosis.criteria import MJCF, SearchBudget
from boom_mj.diagnosis.decision import choose, converged, held_out_loss, ties_with
from boom_mj.diagnosis.scoring import Scored, _hidden
from boom_mj.effects import Parameter

WINDOWS = np.repeat(np.arange(40), 25)
ALL = np.ones(1000, bool)
DATA = SimpleNamespace(windows=WINDOWS, held_out=ALL, recording_of=WINDOWS // 20, channel_of=np.zeros(1000, int))
MODEL: Any = SimpleNamespace(criteria=MJCF, budget=SearchBudget(), data=DATA, facts=SimpleNamespace(repeat_s=None))
NOISE = np.random.default_rng(1).normal(size=1000)


def explanation(
    causes: int, residual: np.ndarray, plausible: bool = True, train: float | None = None, sizes: Any = None
) -> Scored:
    """Of causes 1, 2, .. of one size each that leave so much, in training as much unless said."""
    size = Parameter("1", 0.0, -9.0, 9.0, 1.0, likely=(0.0, 1.0))
    values = {"size": 1.0 if plausible else 5.0}
    kind = {"declared": {"size": size}, "values": values, "special_cases": (), "shapes": frozenset()}
    effects = [SimpleNamespace(id=str(k), **kind) for k in range(causes)]
    candidate = SimpleNamespace(places=tuple(range(causes)), parameters=[(k, "size", size) for k in range(causes)])
    scaled = np.ones(causes) if sizes is None else np.array(sizes)
    fit: Any = SimpleNamespace(effects=effects, candidate=candidate, scaled=scaled, residual=residual)
    left = float(np.sqrt(np.mean(residual**2)))
    return Scored(fit, MODEL, left if train is None else train, left, np.full(causes, 0.4))


def leaving(size: float, causes: int, seed: int = 0, **more: Any) -> Scored:
    """Noise, and something of a size that has no pattern."""
    return explanation(causes, NOISE + size * np.random.default_rng(seed).normal(size=1000), **more)


NOMINAL = (10.0, 10.0)


def test_a_second_cause_that_closes_a_twentieth_counts_when_it_is_sure() -> None:
    one = explanation(1, 4.0 * NOISE)
    two = explanation(2, 3.8 * NOISE)
    loss, error = held_out_loss(MODEL, two.fit.residual, one.fit.residual)
    assert loss > 5 * error
    assert choose([two, one], NOMINAL) is two


def test_a_second_cause_within_its_error_does_not() -> None:
    one, two = leaving(3.0, 1, 5), leaving(3.0, 2, 6)
    best, other = sorted((one, two), key=lambda j: j.held_out)
    loss, error = held_out_loss(MODEL, best.fit.residual, other.fit.residual)
    assert loss < error
    assert choose([best, other], NOMINAL) is one


@pytest.mark.parametrize("left", [4.4, 4.6])
def test_what_fits_training_half_as_well_again_is_no_equal(left: float) -> None:
    """Where held-out data do not tell two explanations apart, training may."""
    one, two = leaving(3.0, 1, 5, train=left), leaving(2.95, 2, 6, train=3.0)
    loss, error = held_out_loss(MODEL, two.fit.residual, one.fit.residual)
    assert 0 < loss < error and one.rivals(two) == (left < 4.5)
    assert choose([two, one], NOMINAL) is (one if left < 4.5 else two)


@pytest.mark.parametrize(("better", "chosen"), [(2.5, "likely"), (1.0, "unlikely")])
def test_an_unlikely_size_must_leave_half_of_what_a_likely_one_leaves(better: float, chosen: str) -> None:
    likely, unlikely = leaving(4.0, 1, 5), leaving(better, 1, 6, plausible=False)
    found = choose([unlikely, likely], NOMINAL)
    assert found is {"likely": likely, "unlikely": unlikely}[chosen]


@pytest.mark.parametrize(("left", "likely", "ties"), [(3.0, True, True), (3.0, False, False), (1.3, False, True)])
def test_an_unlikely_rival_ties_only_where_it_leaves_half(left: float, likely: bool, ties: bool) -> None:
    best, other = leaving(3.0, 1, 5), leaving(left, 1, 6, plausible=likely)
    other.fit.candidate.places = (7,)
    assert ties_with(MODEL, best, other, NOMINAL[1]) == ties


def test_the_worst_moments_do_not_outvote_all_others() -> None:
    """One window of forty that gets worse by more than all others get better."""
    one = 4.0 * NOISE
    two = np.where(WINDOWS == 7, 20.0, 3.0) * NOISE
    assert np.mean(two**2) > np.mean(one**2)
    assert choose([explanation(1, one), best := explanation(2, two, train=3.9)], NOMINAL) is best


def test_a_fit_that_ends_worse_than_without_one_of_its_causes_has_not_ended() -> None:
    """What it says of recordings held out is chance, be it as well as it may."""
    one, two = explanation(1, 4.0 * NOISE), explanation(2, 2.0 * NOISE, train=4.5)
    assert choose([two, one], NOMINAL) is one
    assert converged([two, one]) == [one] and converged([two]) == [two]
    assert choose([better := explanation(2, 2.0 * NOISE, train=3.9), one], NOMINAL) is better
    as_well = explanation(2, 2.0 * NOISE, train=one.train * 1.004)  # within what fits end apart
    assert converged([as_well, one]) == [as_well, one]


def test_a_cause_that_came_out_neutral_is_none() -> None:
    idle = explanation(2, 2.0 * NOISE, sizes=(1.0, 0.0))
    assert choose([idle, one := explanation(1, 4.0 * NOISE)], NOMINAL) is one
    assert converged([idle]) == [idle]  # there is no other


def test_an_explanation_whose_causes_all_show_goes_before_one_of_which_one_may_do_nothing() -> None:
    """Two that do each other's part leave less than either, and of neither is the size known."""
    vague = explanation(2, 2.0 * NOISE, sizes=(0.5, 1.0))
    assert choose([vague, one := explanation(1, 4.0 * NOISE)], NOMINAL) is one
    assert choose([vague], NOMINAL) is vague


def test_a_search_ends_when_two_causes_in_turn_were_not_worth_it() -> None:
    one, two = explanation(1, 4.0 * NOISE), explanation(2, 2.0 * NOISE)
    idle = [leaving(3.87, causes, causes, train=4.0) for causes in (2, 3)]  # as large as noise four times as loud
    assert not stages._stuck([one, *idle], NOMINAL, 3) and stages._stuck([one, *idle], NOMINAL, 4)
    assert not stages._stuck([two, one, *idle], NOMINAL, 4) and stages._stuck([two, one, *idle], NOMINAL, 5)


@pytest.mark.parametrize("size", [0.7, 0.8, -0.8])
def test_a_cause_shows_whose_interval_leaves_out_where_it_does_nothing(size: float) -> None:
    """Sizes with a deviation of 0.4: 95 % within 0.784."""
    best = explanation(2, 2.0 * NOISE, sizes=(1.0, size))
    first, second = best.fit.effects
    assert best.shows(first) and best.shows(second) == (abs(size) > 0.784)


def test_few_recordings_make_a_standard_error_no_smaller() -> None:
    """Where stretches are enough, what differs from one to the next counts; two are too few to tell."""
    one, two = leaving(3.0, 1, 5), leaving(2.5, 2, 6)
    by_window = held_out_loss(MODEL, two.fit.residual, one.fit.residual)
    many = SimpleNamespace(**{**vars(DATA), "recording_of": WINDOWS // 5})
    model: Any = SimpleNamespace(criteria=MJCF, data=many, facts=MODEL.facts)
    assert held_out_loss(model, two.fit.residual, one.fit.residual)[1] >= by_window[1]


def test_hidden_error_vanishes_at_the_floor_and_grows_with_what_is_left() -> None:
    """Of a column of ones, n entries a cluster, G clusters: variance (m^2 - 1) n / N = (m^2 - 1) / G."""
    columns, inverse, channel = np.ones((1000, 1)), np.array([[1e-3]]), np.zeros(1000, int)
    unit = NOISE / np.sqrt(np.mean(NOISE**2))
    assert _hidden(inverse, columns, unit, channel, WINDOWS) == pytest.approx(0.0, abs=1e-9)
    assert _hidden(inverse, columns, 3 * unit, channel, WINDOWS) == pytest.approx((9 - 1) / 40)


def test_a_cause_does_not_show_by_its_shape_alone() -> None:
    """Such as the speed below which a friction grows that may be nothing."""
    best = explanation(1, 2.0 * NOISE, sizes=(1.0,))
    (effect,) = best.fit.effects
    assert best.shows(effect)
    effect.shapes = frozenset({"size"})
    assert best.level(effect) == 0.0 and not best.shows(effect)
