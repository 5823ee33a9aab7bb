"""Shares of causes add up to what they close together, whether all orders of adding are tried or some."""

import numpy as np
import pytest

from boom_mj.diagnosis.budget import MOST_SUBSETS, _shapley, _subsets


@pytest.mark.parametrize("count", [1, 2, 5, 6, 8])
def test_shares_add_up_and_of_independent_causes_are_their_own(count: int) -> None:
    rng, subsets = np.random.default_rng(count), _subsets(count)
    at = {subset: k for k, subset in enumerate(subsets)}
    assert len(at) == len(subsets) <= max(MOST_SUBSETS, count * (count - 1) + 2)
    own = rng.uniform(1, 2, count)
    apart = np.array([[100 - sum(own[k] for k in subset) for subset in subsets]])
    assert [float(_shapley(apart, at, k, count)[0]) for k in range(count)] == pytest.approx(list(own))
    entangled = rng.uniform(1, 100, (3, len(subsets)))
    shares = sum(_shapley(entangled, at, k, count) for k in range(count))
    assert shares == pytest.approx(entangled[:, at[()]] - entangled[:, at[tuple(range(count))]])
