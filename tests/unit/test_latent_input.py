"""Inputs in time that no log tells: whitening by what they may do, how strong they are, and what is none."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from boom_mj.diagnosis.latent import UnitResponses, latent_input_of, units_of
from boom_mj.diagnosis.linearisation import Linearisation
from boom_mj.effects import Effect, make_effect
from boom_mj.estimation.latent_input import (
    CORRELATION_S,
    KNOT_S,
    NONE,
    LatentInput,
    Part,
    _steadiness,
    estimate_latent,
    make_part,
    posterior,
)
from boom_mj.systems.predictor import Predictor, dataset_of

WIND, BREEZE = ((make_effect("wind", {"mean_speed": speed, "direction": 1.2}),) for speed in (15.0, 2.0))
STRENGTH = 2.0
UNWHITENED = SimpleNamespace(whitened=lambda rows, columns: columns)


def noise(model: Linearisation) -> np.ndarray:
    weight = model.noise.weight
    return np.where(weight > 0, np.random.default_rng(2).standard_normal(len(weight)), 0.0)


def latent(model: Linearisation, effects: tuple[Effect, ...], residual: np.ndarray) -> LatentInput:
    found = latent_input_of(model.predictor, effects, model.noise, residual, [0])
    assert found is not None
    return found


@pytest.fixture(scope="module")
def gusty(model: Linearisation) -> tuple[LatentInput, np.ndarray]:
    """The latent input that fits a residual, and the residual: noise and gusts of a strength."""
    residual = noise(model)
    (part,) = latent(model, WIND, 9 * residual).parts
    gusts = STRENGTH * np.random.default_rng(3).multivariate_normal(np.zeros(len(part.turn)), prior(len(part.turn)))
    residual[part.rows] += part.responses @ gusts
    return latent(model, WIND, residual), residual


def prior(count: int) -> np.ndarray:
    knots = KNOT_S * np.arange(count)
    return np.exp(-np.abs(knots[:, None] - knots) / CORRELATION_S)


def test_gusts_are_whitened_by_their_covariance(model: Linearisation, gusty: tuple[LatentInput, np.ndarray]) -> None:
    """(1 + s^2 L Q L^T)^(-1/2) takes out of a residual what gusts have added."""
    found, residual = gusty
    (part,) = found.parts
    white, vector = found.without(residual), np.random.default_rng(4).standard_normal(len(residual))
    assert np.std(residual) > 1.5
    assert np.std(white[model.noise.weight > 0]) == pytest.approx(1, abs=0.05)
    covariance = part.responses @ prior(len(part.turn)) @ part.responses.T
    covariance = np.eye(len(residual)) + found.strength**2 * covariance
    assert found.without(vector) @ white == pytest.approx(vector @ np.linalg.solve(covariance, residual), abs=1e-2)


def test_their_strength_is_told(gusty: tuple[LatentInput, np.ndarray]) -> None:
    low, high = gusty[0].interval
    assert low < gusty[0].strength < high
    assert low < STRENGTH < high


@pytest.mark.parametrize(("acts", "steady"), [(10, 1.0), (6, 10 / 6), (4, 0.0)])
def test_what_never_rests_is_steady(acts: int, steady: float) -> None:
    """Median power of windows over the mean, of an input that acts in some of ten windows, and as much in each."""
    count, strength, power = 200, 3.0, 50.0
    unit = np.eye(count)
    part = Part(slice(0, count), unit, unit, unit, np.full(count, power))
    signs = np.random.default_rng(5).choice([-1.0, 1.0], count) * (np.arange(count) < count * acts / 10)
    assert _steadiness([part], strength, strength * np.sqrt(power) * signs, count // 10) == pytest.approx(steady)


@pytest.mark.filterwarnings("error")
def test_what_nothing_hears_is_not_steady() -> None:
    part = make_part(slice(0, 30), np.zeros((30, 8)), KNOT_S * np.arange(8))
    assert part.power.size == 0 and _steadiness([part], 3.0, np.ones(30), 4) == 0.0
    assert estimate_latent([part], [part], np.ones(30), 4 * KNOT_S, np.inf) is NONE


def test_units_are_simulated_where_a_load_ends_and_nothing_moves(model: Linearisation) -> None:
    knots, chosen = units_of(model.predictor, 0)
    phases = model.system.timeline(model.data.recordings[0]).phases()
    ended = 1 + np.flatnonzero((phases[1:] != phases[:-1]) & np.char.startswith(phases[1:], "after"))
    assert len(ended) == 1 and chosen[0] == 0
    assert knots[chosen[1:]] == pytest.approx(ended * model.data.block_s, abs=KNOT_S)


def test_an_input_is_known_in_time_as_its_prior_and_what_it_does_let_it(
    model: Linearisation, gusty: tuple[LatentInput, np.ndarray]
) -> None:
    """Mean s^2 Q L^T V^-1 r and covariance s^2 Q - s^2 Q L^T V^-1 L s^2 Q, with V = 1 + s^2 L Q L^T."""
    found, residual = gusty
    (part,) = found.parts
    square = found.strength**2 * prior(len(part.turn))
    shared = square @ part.responses.T.astype(float)
    known = np.linalg.solve(np.eye(len(part.responses)) + part.responses @ shared, np.c_[residual[part.rows], shared.T])
    mean, deviation = posterior(part, residual)
    true = np.sqrt(np.diag(square - shared @ known[:, 1:]))
    assert np.abs(mean - shared @ known[:, 0]).max() < 0.05 * true.max()
    assert deviation == pytest.approx(true, rel=0.02)


def test_without_a_wind_there_are_no_gusts(model: Linearisation, gusty: tuple[LatentInput, np.ndarray]) -> None:
    """What a mild one would have to do is done by something else."""
    assert latent(model, BREEZE, gusty[1]) is NONE
    assert NONE.without(gusty[1]) == pytest.approx(gusty[1])


def test_only_what_has_a_latent_input_is_whitened_by_one(model: Linearisation) -> None:
    assert model.conditional_on((make_effect("tip_payload", {"mass": 40.0}),)).latent is None
    windy = model.conditional_on(WIND)
    assert windy.latent is not None and windy.conditional_on(()).latent is None
    assert windy.conditional_on(WIND).latent is windy.latent and windy.allowing(WIND).latent is windy.latent


@pytest.mark.parametrize("missing", [(7.58, 8.18), (0.0, 7.48), (8.38, 9.9)], ids=["hole", "late start", "early end"])
def test_what_a_stream_lacks_moves_no_response(model: Linearisation, missing: tuple[float, float]) -> None:
    """Markers that miss blocks feel every gust at the others as before."""
    data, (start, stop) = model.data, missing
    log = data.recordings[0]
    there = (log["markers"].time < start) | (log["markers"].time > stop)
    markers = replace(log["markers"], time=log["markers"].time[there], values=log["markers"].values[there])
    holed = dataset_of(model.system, [log.with_signals({"markers": markers})], 1)
    whitened, other = (
        UnitResponses.begin(predictor, WIND, WIND[0], 0).whitened(predictor, UNWHITENED)
        for predictor in (model.predictor, Predictor(model.system, holed, threads=1))
    )
    for number, channel in enumerate(data.channels):
        whole, own = whitened[data.stretch(number)], other[holed.stretch(number)]
        kept = np.isin(channel.blocks, holed.channels[number].blocks)
        assert np.count_nonzero(kept) > 3 and kept.all() == (channel.signal != "markers")
        assert np.allclose(own, whole[kept], atol=1e-6 + 1e-3 * np.abs(whole).max())
