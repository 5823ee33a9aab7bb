"""Laws of estimation, on synthetic linear problems: intervals hold the truth, and rows have no order."""

from collections.abc import Callable
from dataclasses import fields, replace
from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest

from boom_mj.diagnosis.criteria import BOOM, MJCF, OF_KIND, Criteria, SearchBudget, described
from boom_mj.diagnosis.fitting import Fit
from boom_mj.diagnosis.scoring import deviations
from boom_mj.estimation.bootstrap import closure, gap, worse_by
from boom_mj.estimation.dataset import Dataset, make_dataset
from boom_mj.estimation.intervals import Z95, robust_variance
from boom_mj.estimation.least_squares import OPTIONS
from boom_mj.estimation.linear import LIMIT, LinearPosterior
from boom_mj.estimation.noise import NoiseModel
from boom_mj.recording import Recording, Signal

Array = np.ndarray
LASTS_S, RATE_HZ, BLOCK_S, CORRELATION_S = 60.0, 20.0, 0.1, 1.0
PARAMETERS, NUISANCES = 3, 4
DRAWS = 2000  # of 3 parameters each: a coverage of 95 % scatters by 0.3 %, a sixth of how far it may be off
MOST = 2.0  # prior deviations of a nuisance that is none of those held at their limit


@cache
def data(louder: float = 1.0) -> Dataset:
    """Three recordings of two signals, one and two channels; the last is held out. Their noise may exceed its least."""
    time, levels = np.arange(0, LASTS_S, 1 / RATE_HZ), {"a": np.array([1.0]), "b": np.array([0.3, 2.0])}
    rng = np.random.default_rng(0)

    def signal(name: str) -> Signal:
        values = louder * levels[name] * rng.standard_normal((len(time), len(levels[name])))
        return Signal(time, values, tuple(f"{name}{k}" for k in range(len(levels[name]))), "1", "world")

    logs = [Recording(f"log{k}", "none", "", {name: signal(name) for name in levels}) for k in range(3)]
    spans = [(0.0, LASTS_S)] * len(logs)
    group = "{}/{}".format
    return make_dataset(logs, 2, spans, levels, group, BLOCK_S, CORRELATION_S, lambda t, lasts: t < 0.6 * lasts)


@cache
def columns() -> tuple[Array, Array]:
    """What parameters and nuisances change, (N, 3) and (N, 4): waves in every channel, as large as its noise."""
    rng, own, count = np.random.default_rng(1), data().channel_of, len(data().channels)

    def wave() -> Array:
        size, rate, phase = rng.standard_normal(count), rng.uniform(1, 9, count), rng.uniform(0, 6, count)
        return 0.3 * data().noise * size[own] * np.sin(rate[own] * data().time + phase[own])

    found = np.stack([wave() for _ in range(PARAMETERS + NUISANCES)], axis=1)
    return found[:, :PARAMETERS], found[:, PARAMETERS:]


def white_noise(rng: np.random.Generator) -> tuple[Array, Array]:
    """A residual without anything in it, and what of it the noise model takes for the model's error, (N,) each."""
    return data().noise * rng.standard_normal(len(data().time)), np.zeros(len(data().time))


def correlated_noise(rng: np.random.Generator) -> tuple[Array, Array]:
    """As much again that stays the same all through a window, in each channel; the noise model knows nothing of it."""
    plain, nothing = white_noise(rng)
    number = data().windows * len(data().channels) + data().channel_of
    return plain + data().noise * rng.standard_normal(number.max() + 1)[number], nothing


def model_error(rng: np.random.Generator) -> tuple[Array, Array]:
    """A wave that is wrong all along each channel by chance, and that the noise model knows."""
    plain, _ = white_noise(rng)
    error = 2 * data().noise * np.cos(2 * data().time)
    return plain + error * data().spread(rng.standard_normal(len(data().channels))), error


def posterior(error: Array, of: Dataset, nuisances: Array) -> LinearPosterior:
    weight = np.where(of.used, 1 / of.noise, 0.0)
    return LinearPosterior.of(NoiseModel(of, weight, error), nuisances)


def estimated(
    about: LinearPosterior, measured: Array, changes: Array, criteria: Criteria = BOOM
) -> tuple[Array, Array]:
    """Parameters and their deviations, (p,) each, by the step that fits take, and the deviations that scores have."""
    train = about.noise.data.train
    jacobian = np.stack([about.noise.white(column) for column in changes.T], axis=1)
    white = about.noise.white(measured)
    left, estimate = about.left(white)
    felt = about.project(jacobian, about.free(estimate))[train]
    prior = np.eye(changes.shape[1]) / OPTIONS.prior**2
    found = np.linalg.solve(jacobian[train].T @ felt + prior, jacobian[train].T @ left)
    residual = about.clean(white - jacobian @ found)
    fit = Fit(SimpleNamespace(), found, (), residual, np.where(train[:, None], jacobian, 0.0), 0.0)
    about_it = {
        "facts": SimpleNamespace(repeat_s=None),
        "system": None,
        "nuisances": range(len(about.some)),
        "criteria": criteria,
    }
    model = SimpleNamespace(data=about.noise.data, posterior=about, **about_it)
    return found, deviations(model, fit)


@pytest.mark.parametrize("louder", [0.8, 1.0, 1.2])
def test_noise_is_what_all_channels_of_a_signal_show_and_no_less_than_its_least(louder: float) -> None:
    noise = {(c.signal, c.column): c.noise for c in data(louder).channels}
    least = {("a", 0): 1.0, ("b", 0): 0.3, ("b", 1): 2.0}
    for channel, level in least.items():
        assert 0.9 * max(louder, 1.0) < noise[channel] / level < 1.02 * max(louder, 1.0)


@pytest.mark.parametrize(
    ("noise", "criteria", "most"),
    [
        (white_noise, BOOM, 0.97),
        (correlated_noise, BOOM, 0.97),
        (model_error, BOOM, 0.97),
        (white_noise, MJCF, 0.985),  # wider by what might hide, of which chance in the residual's size shows a little
    ],
)
def test_intervals_of_95_percent_hold_the_truth_as_often(
    noise: Callable[[np.random.Generator], tuple[Array, Array]], criteria: Criteria, most: float
) -> None:
    rng, (changes, nuisances) = np.random.default_rng(2), columns()
    _, error = noise(rng)
    about, held = posterior(error, data(), nuisances), 0
    for _ in range(DRAWS):
        truth = rng.standard_normal(PARAMETERS)
        hidden = np.clip(rng.standard_normal(NUISANCES), -MOST, MOST)
        measured = changes @ truth + nuisances @ hidden + noise(rng)[0]
        found, deviation = estimated(about, measured, changes, criteria)
        held += np.count_nonzero(np.abs(found - truth) < Z95 * deviation)
    assert 0.93 < held / (DRAWS * PARAMETERS) < most


def drawn() -> tuple[Array, Array]:
    """A measurement, and the windows."""
    changes, nuisances = columns()
    rng = np.random.default_rng(3)
    return changes @ [1.0, -2.0, 0.5] + nuisances @ [0.5, 1.0, -1.5, 0.2] + white_noise(rng)[0], data().windows


def test_the_order_of_channels_does_not_matter() -> None:
    """Those of a recording: the long vector lies otherwise, and what is found stays."""
    measured, (changes, nuisances) = drawn()[0], columns()
    error = np.cos(data().time) * data().noise
    numbers = [k for log in range(3) for k in np.random.default_rng(log).permutation(3) + 3 * log]
    other = replace(data(), channels=tuple(data().channels[k] for k in numbers))
    moved = np.concatenate([np.arange(len(data().time))[data().stretch(k)] for k in numbers])
    assert np.array_equal(other.measured, data().measured[moved]) and not np.array_equal(moved, np.sort(moved))
    assert np.array_equal(other.train, data().train[moved]) and np.array_equal(other.windows, data().windows[moved])
    ours, theirs = posterior(error, data(), nuisances), posterior(error[moved], other, nuisances[moved])
    white = ours.noise.white(measured)
    assert theirs.noise.white(measured[moved]) == pytest.approx(white[moved], abs=1e-12)
    assert theirs.estimate(white[moved]) == pytest.approx(ours.estimate(white), abs=1e-9)
    again = estimated(theirs, measured[moved], changes[moved])
    for one, two in zip(estimated(ours, measured, changes), again):
        assert two == pytest.approx(one, abs=1e-9)


def test_the_order_of_rows_and_the_names_of_clusters_do_not_matter() -> None:
    measured, windows = drawn()
    rng = np.random.default_rng(4)
    before, after = measured / data().noise, rng.standard_normal(len(measured))
    order, renamed = rng.permutation(len(windows)), rng.permutation(windows.max() + 1)
    score = np.stack([before, after], axis=1)
    inverse = np.linalg.inv(score.T @ score)
    expected = robust_variance(inverse, score, [windows])
    assert robust_variance(inverse, score[order], [windows[order]]) == pytest.approx(expected)
    assert robust_variance(inverse, score, [renamed[windows]]) == pytest.approx(expected)
    assert worse_by(windows[order], after[order], before[order]) == pytest.approx(worse_by(windows, after, before))
    one, two = (
        closure(w, b, a) for w, b, a in ((windows, before, after), (windows[order], before[order], after[order]))
    )
    assert (two.value, two.low, two.high) == pytest.approx((one.value, one.low, one.high))
    rows = data().held_out
    assert gap(before[order], rows[order]) == pytest.approx(gap(before, rows))


def test_equal_columns_are_told_by_the_prior_alone() -> None:
    """Half of either, or all of one: each may be anything, and the interval says so."""
    measured, (changes, nuisances) = drawn()[0], columns()
    about = posterior(np.zeros(len(measured)), data(), nuisances)
    found, deviation = estimated(about, measured, np.stack([changes[:, 0], changes[:, 0], changes[:, 1]], axis=1))
    assert deviation[:2] == pytest.approx(OPTIONS.prior / np.sqrt(2), rel=0.01) and deviation[2] < 0.1
    assert found[0] == pytest.approx(found[1], abs=0.01)


def test_a_nuisance_that_goes_further_is_held_at_its_limit() -> None:
    changes, nuisances = columns()
    about = posterior(np.zeros(len(changes)), data(), nuisances)
    estimate = about.estimate(about.noise.white(nuisances @ [0.0, 5.0, -5.0, 1.0]))
    assert estimate[1:3] == pytest.approx([LIMIT, -LIMIT]) and list(about.free(estimate)) == [True, False, False, True]
    bare = LinearPosterior.of(about.noise, nuisances[:, :0])
    white = about.noise.white(changes[:, 0])
    assert bare.estimate(white).shape == (0,) and np.array_equal(bare.clean(white), white)


def test_a_nuisance_that_there_is_not_leaves_what_there_is_without_its_column() -> None:
    changes, nuisances = columns()
    whole = posterior(np.zeros(len(changes)), data(), nuisances)
    some = np.array([True, False, True, True])
    less, bare = replace(whole, some=some), posterior(np.zeros(len(changes)), data(), nuisances[:, some])
    white = whole.noise.white(drawn()[0])
    assert less.estimate(white)[some] == pytest.approx(bare.estimate(white)) and less.estimate(white)[1] == 0
    assert less.trained[:, some] == pytest.approx(bare.trained) and not less.trained[:, 1].any()
    assert less.clean(white) == pytest.approx(bare.clean(white), abs=1e-6)
    free = np.ones(4, bool)
    assert less.project(changes, free) == pytest.approx(bare.project(changes, free[some]), abs=1e-6)


def test_what_is_held_out_is_whitened_by_what_training_leaves_open_of_nuisances() -> None:
    """V = 1 + H (1 + B^T B)^-1 H^T, of a recording by itself; B and H by plain algebra."""
    changes, nuisances = columns()
    about = posterior(np.zeros(len(changes)), data(), 30 * nuisances)
    white, train, held_out = about.noise.white(drawn()[0]), data().train, data().held_out
    whole = 30 * nuisances / data().noise[:, None]
    curvature = np.eye(NUISANCES) + whole[train].T @ whole[train]
    assert about.basis.curvature == pytest.approx(curvature, rel=1e-5)
    estimate = about.estimate(white)
    assert estimate == pytest.approx(np.linalg.solve(curvature, whole[train].T @ white[train]), abs=1e-6)
    left, seen = (white - whole @ estimate)[held_out], whole[held_out]
    known = np.linalg.inv(curvature + seen.T @ seen)  # by Woodbury's identity V^-1 = 1 - H of this H^T
    found = about.clean(white)[held_out]
    assert found @ found == pytest.approx(left @ left - left @ seen @ known @ seen.T @ left, rel=1e-6)
    again = (about.clean(2 * white)[held_out] + found) / 3  # linear, and all it takes away is of H
    assert again == pytest.approx(found, abs=1e-5)
    taken = left - found
    assert seen @ np.linalg.lstsq(seen, taken)[0] == pytest.approx(taken, abs=1e-4)
    assert np.linalg.norm(taken) > 0.1


# Criteria


def test_every_number_that_decides_has_a_unit_and_a_reason() -> None:
    for family in (Criteria, SearchBudget):
        for one in fields(family):
            assert one.metadata["unit"] and len(one.metadata["reason"].split()) > 2, one.name
            assert isinstance(one.default, int | float), one.name
    listed = {(family, one.name) for family, one, _ in described()}
    for name, family in (("criteria", Criteria), ("search", SearchBudget)):
        assert {one.name for one in fields(family)} == {n for f, n in listed if f == name}
    for *_, values in described():
        assert values.keys() == OF_KIND.keys() == {"boom", "mjcf"}
        assert all(isinstance(value, int | float) for value in values.values())
