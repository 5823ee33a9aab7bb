"""How sure of a size one can be whose cost has many minima."""

from dataclasses import replace

import numpy as np
import pytest

from boom_mj.diagnosis.candidate import Candidate
from boom_mj.diagnosis.fitting import Fit
from boom_mj.diagnosis.linearisation import Linearisation
from boom_mj.diagnosis.scoring import SCAN, Scored, profiled
from boom_mj.effects import make_effect


def scored(model: Linearisation, kind: str, **values: float) -> Scored:
    """A fit that is as sure as derivatives may be: they are so large that no step leads anywhere."""
    candidate, left = Candidate((make_effect(kind, values),)), np.zeros(len(model.noise.weight))
    steep = np.where(model.data.train, 1e9, 0.0)[:, None]
    fit = Fit(candidate, candidate.start, candidate.effects, left, steep, 0.0)
    return Scored(fit, model, 1.0, 1.0, np.array([1e-6]))


def test_sizes_that_the_models_own_error_allows_are_within_a_backlashs_interval(model: Linearisation) -> None:
    found = scored(model, "slew_backlash", half_gap=0.004)
    (reach,) = 1.96 * profiled(found, before=1e9).deviation
    scanned = found.fit.scaled[0] * SCAN
    assert reach == pytest.approx(np.hypot(scanned[-1], 1.96 * np.sqrt(np.mean(scanned**2))), rel=1e-3)
    assert profiled(replace(found, train=0.0), before=1.0).deviation == found.deviation


def test_where_the_cost_has_one_minimum_derivatives_tell(model: Linearisation) -> None:
    found = scored(model, "tip_payload", mass=50.0)
    assert profiled(found, before=1e9).deviation == found.deviation
