"""Shares of causes add up to what they close together, whether all orders of adding are tried or some."""

from dataclasses import replace

import numpy as np
import pytest

from boom_mj.diagnosis.budget import MOST_SUBSETS, odds, shapley, subsets_of
from boom_mj.diagnosis.candidate import Candidate
from boom_mj.diagnosis.criteria import BOOM, MJCF, Criteria
from boom_mj.diagnosis.fitting import Fit
from boom_mj.diagnosis.linearisation import Linearisation
from boom_mj.diagnosis.scoring import Scored
from boom_mj.effects import make_effect


@pytest.mark.parametrize("count", [1, 2, 5, 6, 8])
def test_shares_add_up_and_of_independent_causes_are_their_own(count: int) -> None:
    rng, subsets = np.random.default_rng(count), subsets_of(count)
    at = {subset: k for k, subset in enumerate(subsets)}
    assert len(at) == len(subsets) <= max(MOST_SUBSETS, count * (count - 1) + 2)
    own = rng.uniform(1, 2, count)
    apart = np.array([[100 - sum(own[k] for k in subset) for subset in subsets]])
    assert [float(shapley(apart, at, k, count)[0]) for k in range(count)] == pytest.approx(list(own))
    entangled = rng.uniform(1, 100, (3, len(subsets)))
    shares = sum(shapley(entangled, at, k, count) for k in range(count))
    assert shares == pytest.approx(entangled[:, at[()]] - entangled[:, at[tuple(range(count))]])


def explanation(model: Linearisation, residual: np.ndarray) -> Scored:
    effect = make_effect("tip_payload", {"mass": 20.0})
    fit = Fit(Candidate((effect,)), np.ones(1), (effect,), residual, np.zeros((len(residual), 1)), 0.0)
    return Scored(fit, model, 1.0, 1.0, np.ones(1))


def test_what_recordings_do_not_show_may_be_there(model: Linearisation) -> None:
    size = len(model.noise.weight)
    found = [odds(np.full(size, 1.0), (), model, unseen=share) for share in (0.0, 0.2, 1.0)]
    for name, causes in (("hidden", model.criteria.further), ("unwell", model.criteria.unwell)):
        expected = [0, 1 - np.exp(-0.2 * causes), 1 - np.exp(-causes)]
        assert [getattr(one, name) for one in found] == pytest.approx(expected)


@pytest.mark.parametrize("left", [0.9, 3.0])
def test_odds_add_up_and_what_mimics_others_is_less_sure(model: Linearisation, left: float) -> None:
    size = len(model.noise.weight)
    scored = [explanation(model, np.full(size, left))]
    found = [odds(np.full(size, 5.0), scored, model, [count]) for count in (0.0, 0.5, 1.0)]
    for one in found:
        whole = sum(one.explanations) + one.outside_library + one.none + one.combination
        assert whole == pytest.approx(1) and one.none == 0
    if left < 1:
        sure = [one.explanations[0] for one in found]
        assert 0.9 < sure[0] < 1 and sure[0] > sure[1] > sure[2] and not found[0].combination
    else:
        assert found[0] == found[2] and found[0].explanations == (0.0,)
        assert found[0].outside_library > found[0].combination > 0


def test_explanations_that_leave_as_little_by_as_few_causes_are_as_likely(model: Linearisation) -> None:
    """On a machine whose every part may be a little off; of a boom the cheapest alone."""
    size = len(model.noise.weight)
    parts = [1.2, 1.21, 1.3, 1.19]

    def found(criteria: Criteria) -> tuple[float, ...]:
        here = replace(model, criteria=criteria)
        scored = [explanation(here, np.full(size, left)) for left in parts]
        two = replace(scored[3].fit, effects=scored[3].fit.effects * 2)
        return odds(np.full(size, 5.0), [*scored[:3], replace(scored[3], fit=two)], here).explanations

    alike = found(MJCF)
    assert alike[0] == alike[1] > 0.4 and alike[2:] == (0.0, 0.0)
    cheapest = found(replace(BOOM, explained_gap=1.5))
    assert cheapest[3] > 0.9 and cheapest[:3] == (0.0, 0.0, 0.0)
