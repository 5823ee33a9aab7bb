"""Sums of terms promise what their columns explain, and no more than the precision of these lets them."""

import importlib
from types import SimpleNamespace

import numpy as np
import pytest

from boom_mj.diagnosis.clock import Clock
from boom_mj.diagnosis.criteria import Criteria, SearchBudget
from boom_mj.discovery import search
from boom_mj.discovery.places import Place
from boom_mj.discovery.search import FoundLaw
from boom_mj.effects import Site, laws
from boom_mj.estimation.least_squares import OPTIONS

SIZE = 1e6  # of a column's square
SINGLE = 1e-7  # precision of what is stored

DISCOVER = importlib.import_module("boom_mj.discovery.discover")


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


def test_terms_that_cancel_most_of_each_other_are_found_together(monkeypatch: pytest.MonkeyPatch) -> None:
    """A gain that depends on the angle is load, and load times angle: neither may help alone."""
    rng, count = np.random.default_rng(0), 500
    words = {"x": "m", "F": "N", "creep": 1e-3, "middle": 0.0}
    place = Place(laws.CylinderLaw, Site((("cylinder", 2),)), "a cylinder", {}, 1.0, words)
    plain = [term for term in place.terms if not term.shape]
    drawn = rng.standard_normal((count, len(plain)))
    names = [term.name for term in plain]
    load, angle = names.index("load_scale"), names.index("load_angle")
    other = rng.standard_normal(count)
    drawn[:, load], drawn[:, angle] = 10 + other, 10 - other
    left = drawn[:, load] - drawn[:, angle]
    for k in set(range(len(names))) - {load, angle}:
        drawn[:, k] += left
    own = [search.Column(place, term, None, slice(k, k + 1)) for k, term in enumerate(plain)]
    monkeypatch.setattr(search, "_typical", lambda *given: 1.0)
    numbers, whole = np.arange(len(plain)), float(left @ left)
    found = search._beam(place, own, numbers, drawn.T @ left, drawn.T @ drawn, whole, SearchBudget())
    pairs = [{term.name for term in one.terms} for one in found if len(one.terms) == 2]
    assert pairs[0] == {"load_scale", "load_angle"}
    singles = {one.terms[0].name for one in found if len(one.terms) == 1}
    assert not singles & pairs[0]  # neither was among the best alone


def fitted(name: str, left: float, white: np.ndarray) -> SimpleNamespace:
    """An effect or a law that leaves so much."""
    effect = SimpleNamespace(id=name)
    fit = SimpleNamespace(effects=(effect,), candidate=SimpleNamespace(places=name), residual=left * white)
    return SimpleNamespace(held_out=left, fit=fit)


def machine(count: int) -> SimpleNamespace:
    rows = np.arange(count) < count // 2
    data = SimpleNamespace(train=rows, held_out=~rows, windows=np.arange(count) // 40)
    return SimpleNamespace(data=data, system=None, criteria=Criteria(), budget=SearchBudget())


def test_an_effect_that_a_rough_fit_leaves_behind_a_law_is_fitted_about_the_machine_of_the_law(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A payload by its one mass, fitted roughly, left 1.46, weight and inertia apart 1.28: both were the same."""
    white = np.random.default_rng(0).standard_normal(4000)
    scored = [fitted("tip_payload", 1.46, white), fitted("link_mass", 7.0, white)]
    asked, about = [], object()

    def fit_all(model: object, candidates: list, clock: Clock) -> list:
        asked.extend((model, one.effects[0].id) for one in candidates)
        return [fitted(one.effects[0].id, 0.98, white) for one in candidates]

    for name, found in (
        ("Screening", lambda *given: SimpleNamespace(rank=lambda raw: [SimpleNamespace(share=1.0)])),
        ("everywhere", lambda system: []),
        ("spectral_lines", lambda model, residual: []),
        ("singles", lambda *given: scored),
        ("fit_all", fit_all),
    ):
        monkeypatch.setattr(DISCOVER, name, found)
    law = SimpleNamespace(held_out=1.28, residual=1.28 * white)
    for without in ((), ("tip_payload",)):
        found = DISCOVER._library(machine(4000), None, 9.0 * white, law, about, without, Clock())
        assert [one.held_out for one in found] == [0.98, 7.0] and asked == [(about, "tip_payload")]
        asked.clear()


@pytest.mark.parametrize(("there", "taken"), [(0.99, "hardens"), (1.36, "gives")])
def test_a_law_that_leaves_less_is_tried_about_the_machine_of_the_shortest(
    monkeypatch: pytest.MonkeyPatch, there: float, taken: str
) -> None:
    """Ground that hardens, fitted roughly, left 1.26, and ground that gives 1.33, as much: refined, 0.98 and 1.35."""
    white = np.random.default_rng(0).standard_normal(400)

    def law(name: str, left: float, size: int) -> FoundLaw:
        one = fitted(name, left, white)
        one.fit.scaled, one.fit.candidate.parameters, one.model = np.ones(size), [(0, name, name)], name
        one.deviation = np.zeros(size)
        term = SimpleNamespace(name=name, parts=[SimpleNamespace(coefficient=name)])
        return FoundLaw(SimpleNamespace(), (term,), one)

    gives, hardens = law("gives", 1.33, 1), law("hardens", 1.26, 2)
    asked = []

    def fit_all(model: str, candidates: list, clock: Clock) -> list:
        asked.extend((model, one.effects[0].id) for one in candidates)
        return [law("hardens", there, 2).scored for _ in candidates]

    monkeypatch.setattr(DISCOVER, "fit_all", fit_all)
    monkeypatch.setattr(DISCOVER, "refined", lambda scored, *given: scored)
    found = DISCOVER._refined(machine(400), 7.0 * white, [hardens, gives], (7.0, 7.0), Clock())
    assert found.terms[0].name == taken and asked == [("gives", "hardens")]
