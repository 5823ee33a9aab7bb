"""Courses in time that no log tells: whitening by what they may do, and how strong they are."""

import numpy as np
import pytest

from boom_mj.effects import make_effect
from boom_mj.effects.effect import KNOT
from boom_mj.gap.course import TIME, courses_of
from boom_mj.gap.metric import Metric, beside

WIND = (make_effect("wind", {"mean_speed": 6.0, "direction": 1.2}),)


def test_gusts_are_whitened_by_their_covariance(metric: Metric) -> None:
    """What a course of planted strength adds is told from noise, and (1 + s^2 L Q L^T)^(-1/2) takes it out."""
    rng = np.random.default_rng(2)
    (part,) = courses_of(metric.campaign, WIND, metric.whitened, np.zeros(len(metric.weight)), [0]).parts
    knots = KNOT * np.arange(part.responses.shape[1])
    prior = np.exp(-np.abs(knots[:, None] - knots) / TIME)
    gusts = 2.0 * rng.multivariate_normal(np.zeros(len(knots)), prior)
    residual = np.where(metric.weight > 0, rng.standard_normal(len(metric.weight)), 0.0)
    residual[part.rows] += part.responses @ gusts
    found = courses_of(metric.campaign, WIND, metric.whitened, residual, [0])
    assert found.reach[0] < found.strength < found.reach[1]
    assert found.reach[0] < 2.0 < found.reach[1]
    white, vector = found.without(residual), rng.standard_normal(len(residual))
    assert np.std(residual) > 1.5
    assert np.std(white[metric.weight > 0]) == pytest.approx(1, abs=0.05)
    covariance = np.eye(len(residual)) + found.strength**2 * part.responses @ prior @ part.responses.T
    assert found.without(vector) @ white == pytest.approx(vector @ np.linalg.solve(covariance, residual), abs=1e-2)


def test_only_what_has_a_course_is_whitened_by_one(metric: Metric) -> None:
    assert beside(metric, (make_effect("tip_payload", {"mass": 40.0}),)).courses is None
    windy = beside(metric, WIND)
    assert windy.courses and beside(windy, WIND).courses is windy.courses and beside(windy, ()).courses is None
