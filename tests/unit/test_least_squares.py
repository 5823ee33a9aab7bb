"""Least squares by Gauss and Newton's steps against scipy's, within bounds, and where the cost is rough."""

import numpy as np
from pytest import approx, mark
from scipy.optimize import approx_fprime, least_squares

from boom_mj.estimation.least_squares import OPTIONS, Minimum, gauss_newton

Array = np.ndarray
TIME = np.linspace(0, 3, 40)
SEEN = 2.0 * np.exp(-0.7 * TIME) + 0.01 * np.random.default_rng(0).standard_normal(len(TIME))
START = np.array([1.0, 0.2])


def decay(at: Array) -> Array:
    """What an exponential of amplitude and rate leaves, in noise."""
    return (SEEN - at[0] * np.exp(-at[1] * TIME)) / 0.01


def sensitivities(at: Array) -> Array:
    return -np.stack([approx_fprime(at, lambda x, k=k: decay(x)[k]) for k in range(len(TIME))])


def found(high: float = 9.0, prior: float = 0.0, start: Array = START, **options: object) -> Minimum:
    bounds, priors = (np.zeros(2), np.array([9.0, high])), np.full(2, prior)
    return gauss_newton(decay, sensitivities(start), start, bounds, priors, lambda cost: 1e-9, **options)


@mark.parametrize(("high", "prior"), [(9.0, 0.0), (0.5, 0.0), (9.0, 300.0)], ids=["free", "at a bound", "prior"])
def test_ends_where_scipys_least_squares_do(high: float, prior: float) -> None:
    best = least_squares(lambda x: np.r_[decay(x), np.sqrt(prior) * x], START, bounds=([0, 0], [9, high]))
    end = found(high, prior, iterations=50)
    assert end.at == approx(best.x, abs=1e-4)  # deviations are thirty times as large
    assert end.cost == approx(best.cost, abs=1e-3)
    assert end.residual == approx(decay(end.at))


def test_says_how_it_ended() -> None:
    assert found(iterations=50).reason == "converged"
    assert found(iterations=2).reason == "no end after 2 steps"
    useless = gauss_newton(
        lambda at: np.array([1.0]), np.ones((1, 2)), START, (START - 9, START + 9), np.zeros(2) + 1e-6, lambda cost: 0.0
    )
    assert useless.reason == f"{OPTIONS.idle} steps promised more than they brought"


def test_sensitivities_may_be_renewed_where_a_step_has_led() -> None:
    asked = list[Array]()

    def renewed(at: Array) -> Array:
        asked.append(at)
        return sensitivities(at)

    assert found(renewed=renewed, iterations=6).cost < found(iterations=6).cost
    assert asked[-1] == approx(found(iterations=50).at, rel=1e-4)


def test_a_rough_cost_says_how_far_off_it_might_have_ended() -> None:
    tried = list[float]()

    def rough(at: Array) -> Array:
        tried.append(float(at[0]))
        return np.array([1.0 - at[0], 3.0 * (len(tried) > 1)])  # whatever is tried after the start is worse

    columns, one = np.array([[1.0], [0.0]]), np.ones(1)
    end = gauss_newton(rough, columns, 0 * one, (-9 * one, 9 * one), 0 * one, lambda cost: 0.01)
    assert end.at == 0
    assert end.cost == 0.5
    assert end.rough == approx(tried[1])
    assert len(tried) == 3


def test_what_falls_as_promised_is_not_rough() -> None:
    assert np.all(found(iterations=50).rough == 0)
