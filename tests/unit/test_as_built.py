"""What healthy recordings leave unsure of how a machine was built stays its nuisances."""

from itertools import combinations_with_replacement

import numpy as np
import pytest

from boom_mj.diagnosis.healthy import _unsure
from boom_mj.effects import Effect
from boom_mj.systems.boom.nuisances import individual, nuisances
from boom_mj.systems.system import Nuisance

WIDE, USUAL = tuple(individual()), nuisances()
APART = np.array([one.deviation != other.deviation for one, other in zip(WIDE, USUAL)])


def covariance() -> np.ndarray:
    """What recordings leave of unit priors."""
    told = np.random.default_rng(0).standard_normal((40, len(WIDE)))
    return np.linalg.inv(np.eye(len(WIDE)) + told.T @ told)


def sizes(nuisance: Nuisance, causes: list[tuple]) -> np.ndarray:
    """One deviation of a nuisance, by cause."""
    own: dict[tuple, Effect] = {effect.cause: effect for effect in nuisance.hypothesis}
    return np.array([nuisance.deviation * (own[c].values["factor"] - 1) if c in own else 0.0 for c in causes])


def test_they_scatter_as_healthy_recordings_leave_it() -> None:
    found = _unsure(WIDE, USUAL, covariance())
    assert found[: np.sum(~APART)] == tuple(one for one, so in zip(USUAL, APART) if not so)
    own = [one for one, so in zip(WIDE, APART) if so]
    causes = sorted({effect.cause for one in own for effect in one.hypothesis})
    each = np.array([sizes(one, causes) for one in own])
    parts = np.array([sizes(one, causes) for one in found[np.sum(~APART) :]])
    expected = each.T @ covariance()[np.ix_(APART, APART)] @ each
    for k, n in combinations_with_replacement(range(len(causes)), 2):
        assert (parts.T @ parts)[k, n] == pytest.approx(expected[k, n], abs=1e-9)


def test_derivatives_are_taken_by_steps_as_small_as_ever() -> None:
    for one in _unsure(WIDE, USUAL, covariance())[np.sum(~APART) :]:
        largest = max(abs(effect.values["factor"] - 1) for effect in one.hypothesis)
        assert 0.001 < largest < 0.007  # of 0.002 each, those of the same place add up
