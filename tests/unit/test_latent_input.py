"""Courses in time that no log tells: whitening by what they may do, how strong they are, and what is none."""

from dataclasses import replace

import numpy as np
import pytest

from boom_mj.diagnosis import Campaign
from boom_mj.diagnosis.linearisation import Metric, allowed, beside
from boom_mj.effects import make_effect
from boom_mj.effects.effect import COURSE_TIME, KNOT
from boom_mj.estimation.latent_input import NONE, Courses, _Plan, courses_of

WIND, BREEZE = ((make_effect("wind", {"mean_speed": speed, "direction": 1.2}),) for speed in (15.0, 2.0))
STRENGTH = 2.0


def noise(metric: Metric) -> np.ndarray:
    return np.where(metric.weight > 0, np.random.default_rng(2).standard_normal(len(metric.weight)), 0.0)


@pytest.fixture(scope="module")
def gusty(metric: Metric) -> tuple[Courses, np.ndarray]:
    """Courses that fit a residual, and the residual: noise and gusts of a strength."""
    residual = noise(metric)
    (part,) = courses_of(metric.campaign, WIND, metric.whitened, 9 * residual, [0]).parts
    gusts = STRENGTH * np.random.default_rng(3).multivariate_normal(np.zeros(len(part.turn)), prior(len(part.turn)))
    residual[part.rows] += part.responses @ gusts
    return courses_of(metric.campaign, WIND, metric.whitened, residual, [0]), residual


def prior(count: int) -> np.ndarray:
    knots = KNOT * np.arange(count)
    return np.exp(-np.abs(knots[:, None] - knots) / COURSE_TIME)


def test_gusts_are_whitened_by_their_covariance(metric: Metric, gusty: tuple[Courses, np.ndarray]) -> None:
    """(1 + s^2 L Q L^T)^(-1/2) takes out of a residual what gusts have added."""
    found, residual = gusty
    (part,) = found.parts
    white, vector = found.without(residual), np.random.default_rng(4).standard_normal(len(residual))
    assert np.std(residual) > 1.5
    assert np.std(white[metric.weight > 0]) == pytest.approx(1, abs=0.05)
    covariance = part.responses @ prior(len(part.turn)) @ part.responses.T
    covariance = np.eye(len(residual)) + found.strength**2 * covariance
    assert found.without(vector) @ white == pytest.approx(vector @ np.linalg.solve(covariance, residual), abs=1e-2)


def test_their_strength_is_told(gusty: tuple[Courses, np.ndarray]) -> None:
    assert gusty[0].reach[0] < gusty[0].strength < gusty[0].reach[1]
    assert gusty[0].reach[0] < STRENGTH < gusty[0].reach[1]


def test_without_a_wind_there_are_no_gusts(metric: Metric, gusty: tuple[Courses, np.ndarray]) -> None:
    """What a mild one would have to do is done by something else."""
    assert courses_of(metric.campaign, BREEZE, metric.whitened, gusty[1], [0]) is NONE
    assert NONE.without(gusty[1]) == pytest.approx(gusty[1])


def test_only_what_has_a_course_is_whitened_by_one(metric: Metric) -> None:
    assert beside(metric, (make_effect("tip_payload", {"mass": 40.0}),)).courses is None
    windy = beside(metric, WIND)
    assert windy.courses is not None and beside(windy, ()).courses is None
    assert beside(windy, WIND).courses is windy.courses and allowed(windy, WIND).courses is windy.courses


@pytest.mark.parametrize("missing", [(7.58, 8.18), (0.0, 7.48), (8.38, 9.9)], ids=["hole", "late start", "early end"])
def test_what_a_stream_lacks_moves_no_response(metric: Metric, missing: tuple[float, float]) -> None:
    """Markers that miss blocks feel every gust at the others as before."""
    log, (start, stop) = metric.campaign.recordings[0], missing
    there = (log["markers"].time < start) | (log["markers"].time > stop)
    markers = replace(log["markers"], time=log["markers"].time[there], values=log["markers"].values[there])
    holed = Campaign(metric.campaign.subject, [log.with_signals({"markers": markers})], 1, threads=1)
    part, other = (_Plan.of(c, WIND, WIND[0], 0).part(lambda rows, columns: columns) for c in (metric.campaign, holed))
    for number, channel in enumerate(metric.campaign.channels):
        whole, own = part.responses[metric.campaign.stretch(number)], other.responses[holed.stretch(number)]
        kept = np.isin(channel.blocks, holed.channels[number].blocks)
        assert np.count_nonzero(kept) > 3 and kept.all() == (channel.signal != "markers")
        assert np.allclose(own, whole[kept], atol=1e-6 + 1e-3 * np.abs(whole).max())
