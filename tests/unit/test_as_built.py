"""What healthy recordings leave unsure of how a machine was built stays its nuisances."""

from itertools import combinations_with_replacement

import numpy as np
import pytest

from boom_mj.diagnosis.healthy import _deviations, _unsure
from boom_mj.effects import Effect, make_effect
from boom_mj.systems.as_built import AsBuilt
from boom_mj.systems.boom.nuisances import AS_BUILT as WIDER
from boom_mj.systems.boom.nuisances import PLATES, STIFFNESS, VISCOUS, individual, nuisances
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


def test_sizes_as_built_are_as_unsure_as_all_their_nuisances_make_them() -> None:
    found = _deviations(WIDE, np.eye(len(WIDE)))
    friction = make_effect("viscous_friction", {"joint": 3})
    assert found[friction.cause, "factor"] == pytest.approx(VISCOUS / abs(friction.declared["factor"].typical))
    softer = make_effect("link_stiffness", {"link": 4, "axis": "v"})
    expected = WIDER["link_stiffness"] * np.hypot(STIFFNESS["v"], PLATES) / abs(softer.declared["factor"].typical)
    assert found[softer.cause, "factor"] == pytest.approx(expected)


def test_a_change_is_as_unsure_as_what_it_changes() -> None:
    softer, loaded = (
        make_effect("link_stiffness", {"link": 4, "axis": "v", "factor": 0.98}),
        make_effect("tip_payload", {"mass": 20.0}),
    )
    deviations = {(softer.cause, "factor"): 0.1, (loaded.cause, "mass"): 0.2}
    machine = AsBuilt(None, (softer, loaded), (), deviations)  # type: ignore[arg-type]
    assert machine.doubt(type(softer)(softer.site, factor=0.49), "factor") == pytest.approx(0.05)
    assert machine.doubt(type(loaded)(loaded.site, mass=80.0), "mass") == 0.2
    assert machine.doubt(make_effect("viscous_friction", {"joint": 3, "factor": 3.0}), "factor") == 0.0
