"""How sure of a size one can be whose cost has many minima."""

from dataclasses import replace

import numpy as np
import pytest

from boom_mj.diagnosis.candidate import Candidate
from boom_mj.diagnosis.fitting import Fit
from boom_mj.diagnosis.linearisation import Metric
from boom_mj.diagnosis.scoring import LOOKS, Scored, across
from boom_mj.effects import make_effect


def judged(metric: Metric, kind: str, **values: float) -> Scored:
    """A fit that is as sure as derivatives may be."""
    candidate, left = Candidate((make_effect(kind, values),)), np.zeros(len(metric.weight))
    fit = Fit(candidate, candidate.start, candidate.effects, left, left[:, None], 0.0)
    return Scored(fit, metric, 1.0, 1.0, np.array([1e-6]))


def test_sizes_that_the_models_own_error_allows_are_within_a_backlashs_interval(metric: Metric):
    found = judged(metric, "slew_backlash", half_gap=0.004)
    (reach,) = 1.96 * across(found, before=1e9).deviation
    assert reach == pytest.approx(LOOKS[-1] * found.fit.coordinates[0], rel=1e-3)
    assert across(replace(found, train=0.0), before=1.0).deviation == found.deviation


def test_where_the_cost_has_one_minimum_derivatives_tell(metric: Metric):
    found = judged(metric, "tip_payload", mass=50.0)
    assert across(found, before=1e9).deviation == found.deviation
