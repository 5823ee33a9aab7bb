"""Whitening: V^-1/2 of noise and model error together; nuisances that an effect stands for."""

import numpy as np
import pytest

from boom_mj.diagnosis.linearisation import Linearisation, of_size
from boom_mj.effects import make_effect
from boom_mj.estimation.linear import LinearPosterior
from boom_mj.estimation.noise import NoiseModel
from boom_mj.systems.predictor import dataset_of


def test_products_of_whitened_vectors_are_those_of_the_inverse_covariance(model: Linearisation) -> None:
    channel = model.data.stretch(5)
    along = model.facts.fidelity.along
    noise, error = model.data.noise[channel], along * model.mean_error[channel]
    covariance = np.diag(noise**2) + np.outer(error, error)
    x, y = np.random.default_rng(1).standard_normal((2, len(model.noise.weight)))
    ours = model.noise.white(x)[channel] @ model.noise.white(y)[channel]
    assert ours == pytest.approx(x[channel] @ np.linalg.solve(covariance, y[channel]), rel=1e-9)


def test_an_error_all_along_a_channel_counts_no_more_than_its_share(model: Linearisation) -> None:
    white = model.noise.white(model.mean_error)
    for number in range(len(model.data.channels)):
        assert np.linalg.norm(white[model.data.stretch(number)]) < 1 / model.facts.fidelity.along


def test_what_unsure_starts_change_is_whitened_in_each_recording(model: Linearisation) -> None:
    data, rng = model.data, np.random.default_rng(2)
    starts = 3 * data.noise[:, None] * rng.standard_normal((len(data.noise), 2))
    noise = NoiseModel(data, np.where(data.used, 1 / data.noise, 0.0), 0 * data.noise, starts)
    x, y = np.where(data.used, rng.standard_normal((2, len(data.noise))), 0.0)
    for index in range(len(data.recordings)):
        rows = data.rows(index)
        covariance = np.diag(data.noise[rows] ** 2) + starts[rows] @ starts[rows].T
        ours = noise.white(x)[rows] @ noise.white(y)[rows]
        assert ours == pytest.approx(x[rows] @ np.linalg.solve(covariance, y[rows]), rel=1e-6)
        assert noise.whitened(rows, x[rows, None])[:, 0] == pytest.approx(noise.white(x)[rows])


def test_an_effect_stands_for_its_nuisance(model: Linearisation) -> None:
    heavier = (make_effect("link_mass", {"link": 4, "factor": 1.2}),)
    left = model.conditional_on(heavier)
    gone = [k for k, t in enumerate(left.nuisances) if not t.hypothesis]
    assert [model.nuisances[k].hypothesis[0].cause for k in gone] == [heavier[0].cause]
    estimate = left.posterior.estimate(left.residual(left.base))
    assert not left.posterior.trained[:, gone].any() and not estimate[gone].any() and estimate.any()
    assert heavier[0].cause not in {e.cause for e in of_size(left.nuisances, np.ones(len(left.nuisances)))}
    assert model.conditional_on(()) is model


def test_nuisances_at_the_same_place_add_up(model: Linearisation) -> None:
    found = of_size(model.nuisances, np.ones(len(model.nuisances)))
    sizes = {e.cause: e.values["factor"] for e in found if "link" in e.location}
    softer = sizes[make_effect("link_stiffness", {"link": 3, "axis": "v"}).cause]
    assert softer == pytest.approx(1 - 0.005 - 0.003)  # of all links, and of its own plates
    assert len(found) == len({e.cause for e in found})


def test_what_training_does_not_tell_of_nuisances_is_no_gap(model: Linearisation) -> None:
    """What is held out counts by the inverse of 1 + H C^-1 H^T, with C what training tells."""
    posterior, held_out = model.posterior, model.data.held_out
    columns = posterior.basis.whole[held_out].astype(float)
    covariance = np.eye(len(columns)) + columns @ np.linalg.solve(posterior.basis.curvature, columns.T)
    noise = np.random.default_rng(2).standard_normal(len(held_out))
    residual = noise + posterior.basis.whole @ np.linspace(-2, 2, columns.shape[1])
    predicted = (residual - posterior.basis.whole @ posterior.estimate(residual))[held_out]
    expected = predicted @ np.linalg.solve(covariance, predicted)
    assert np.sum(model.clean(residual)[held_out] ** 2) == pytest.approx(expected, rel=1e-5)
    assert abs(predicted @ predicted - expected) > 1e-3 * expected


def test_what_changed_in_one_recording_is_not_seen_in_another(model: Linearisation) -> None:
    """Each that is held out is whitened by itself."""
    data = dataset_of(model.system, [model.data.recordings[0]] * 3, 1)
    rng, noise = np.random.default_rng(3), NoiseModel(data, np.where(data.used, 1 / data.noise, 0.0), 0 * data.time)
    posterior = LinearPosterior.of(noise, rng.standard_normal((len(data.time), 5)) * data.noise[:, None])
    residual, changed = rng.standard_normal(len(data.time)), data.recording_of == 1
    before, after = posterior.clean(residual), posterior.clean(residual + 30 * changed * posterior.basis.whole[:, 0])
    assert np.linalg.norm((after - before)[changed]) > 10
    assert np.array_equal(after[~changed], before[~changed])
