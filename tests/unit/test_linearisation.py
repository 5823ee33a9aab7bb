"""Whitening: V^-1/2 of noise and model error together; nuisances that an effect stands for."""

from pathlib import Path

import numpy as np
import pytest

from boom_mj.diagnosis.linearisation import Metric, beside, of_size
from boom_mj.effects import make_effect
from boom_mj.systems.boom.system import BoomSystem, tolerances

ROOT = Path(__file__).parents[2]
ALIKE = BoomSystem.fidelity.alike


def test_products_of_whitened_vectors_are_those_of_the_inverse_covariance(metric: Metric):
    channel = metric.campaign.stretch(5)
    noise, error = metric.campaign.noise[channel], ALIKE * metric.mean_error[channel]
    covariance = np.diag(noise**2) + np.outer(error, error)
    x, y = np.random.default_rng(1).standard_normal((2, len(metric.weight)))
    ours = metric.white(x)[channel] @ metric.white(y)[channel]
    assert ours == pytest.approx(x[channel] @ np.linalg.solve(covariance, y[channel]), rel=1e-9)


def test_an_error_all_along_a_channel_counts_no_more_than_its_share(metric: Metric):
    white = metric.white(metric.mean_error)
    for number in range(len(metric.campaign.channels)):
        assert np.linalg.norm(white[metric.campaign.stretch(number)]) < 1 / ALIKE


def test_an_effect_stands_for_its_tolerance(metric: Metric):
    heavier = (make_effect("link_mass", {"link": 4, "factor": 1.2}),)
    left = beside(metric, heavier)
    gone = [k for k, t in enumerate(left.nuisances) if not t.hypothesis]
    assert [metric.nuisances[k].hypothesis[0].cause for k in gone] == [heavier[0].cause]
    assert not left.columns[:, gone].any()
    assert heavier[0].cause not in {e.cause for e in of_size(left.nuisances, np.ones(len(left.nuisances)))}
    assert beside(metric, ()) is metric


def test_nuisances_at_the_same_place_add_up():
    sizes = {
        e.cause: e.values["factor"] for e in of_size(tolerances(), np.ones(len(tolerances()))) if "link" in e.location
    }
    softer = sizes["link_stiffness", (("axis", "v"), ("link", 3))]
    assert softer == pytest.approx(1 - 0.005 - 0.003)  # of all links, and of its own plates
