"""Sums of terms promise what their columns explain, and no more than the precision of these lets them."""

import importlib
from types import SimpleNamespace

import numpy as np
import pytest

from boom_mj.diagnosis.clock import Clock
from boom_mj.diagnosis.criteria import Criteria, SearchBudget
from boom_mj.discovery import search
from boom_mj.discovery.places import Place
from boom_mj.effects import Site, laws
from boom_mj.estimation.least_squares import OPTIONS

SIZE = 1e6  # of a column's square
SINGLE = 1e-7  # precision of what is stored


def test_columns_that_are_alike_to_their_precision_promise_nothing_together(monkeypatch: pytest.MonkeyPatch) -> None:
    """Rounding may take an eigenvalue of their normal matrix to where the prior just makes up for it."""
    rng = np.random.default_rng(0)
    column = rng.standard_normal(4000)
    column *= np.sqrt(SIZE) / np.linalg.norm(column)
    place = Place(laws.AngleLaw, Site((("joint", 5),)), "a sensor", {"angle": np.full(9, 1.2)}, 5e-3, {})
    whole = 1e5
    below = (1 - 1e-6) / OPTIONS.prior**2
    assert below < SINGLE * SIZE  # so little is no more than rounding

    class Alike:
        """A screening of two terms that are the same column."""

        def __init__(self, model: object, kinds: list, lines: tuple) -> None:
            self.rows = [(kind, site, kind.screening(site)[0]) for kind, site in kinds]
            self.stretches = [slice(k, k + 1) for k in range(len(kinds))]
            self.columns = np.stack([column] * len(kinds), axis=1).astype(np.float32)

        def normal_equations(self, raw: None) -> tuple:
            square = SIZE * np.ones((2, 2)) + below * np.array([[-0.5, 0.5], [0.5, -0.5]])
            slopes = np.array([1, -1]) * SINGLE * np.sqrt(SIZE * whole)
            return slopes, lambda rows, columns: square[np.ix_(rows, columns)], None, whole

    monkeypatch.setattr(search, "Screening", Alike)
    own = search._screened(SimpleNamespace(budget=SearchBudget()), None, {place: place.terms[:2]})[place]
    assert max(one.share for one in own) < 0.01


def test_an_effect_that_a_rough_fit_leaves_behind_a_law_is_refined_as_the_law_is(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A payload by its one mass, fitted roughly, left 1.46, weight and inertia apart 1.28: both were the same."""
    discovery = importlib.import_module("boom_mj.discovery.discover")
    effects = {name: SimpleNamespace(id=name) for name in ("tip_payload", "link_mass")}
    white = np.random.default_rng(0).standard_normal(4000)
    scored = [
        SimpleNamespace(held_out=left, fit=SimpleNamespace(effects=(effects[name],), residual=left * white))
        for name, left in (("tip_payload", 1.46), ("link_mass", 7.0))
    ]
    asked = []
    monkeypatch.setattr(
        discovery, "Screening", lambda *given: SimpleNamespace(rank=lambda raw: [SimpleNamespace(share=1.0)])
    )
    monkeypatch.setattr(discovery, "everywhere", lambda system: [])
    monkeypatch.setattr(discovery, "spectral_lines", lambda model, residual: [])
    monkeypatch.setattr(discovery, "singles", lambda *given: scored)
    monkeypatch.setattr(discovery, "refined", lambda rivals, *given: asked.extend(rivals) or list(rivals))
    rows = np.arange(len(white)) < len(white) // 2
    data = SimpleNamespace(train=rows, held_out=~rows, windows=np.arange(len(white)) // 40)
    model = SimpleNamespace(data=data, system=None, criteria=Criteria(), budget=SearchBudget())
    law = SimpleNamespace(held_out=1.28, residual=1.28 * white)
    for without in ((), ("tip_payload",)):
        found = discovery._library(model, None, 9.0 * white, law, without, Clock())
        assert found == scored and asked == scored[:1]
        asked.clear()
