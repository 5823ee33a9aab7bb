"""Partners of a leader: a glance that tells spares simulations, and one that does not costs no partner."""

from collections.abc import Callable
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

from algebra import HUM, LATE, RAMP, SQUARE, TIME, Ramp, causes, model, predictor, term
from pytest import MonkeyPatch, approx, fixture, mark

from boom_mj.diagnosis import diagnose, stages
from boom_mj.diagnosis.candidate import Candidate, everywhere
from boom_mj.diagnosis.clock import Clock
from boom_mj.diagnosis.criteria import SearchBudget
from boom_mj.diagnosis.screening import Screening

LASTS = TIME[-1]
Partners = Callable[[], list[tuple]]


@fixture
def partners(library: None, monkeypatch: MonkeyPatch) -> tuple[Partners, list[int]]:
    """Of a square, best first; and how many kinds every screening simulates."""
    about, simulated = model((SQUARE, HUM, RAMP)), list[int]()
    screening = Screening(about, everywhere(about.system, ()), [])

    class Counted(Screening):
        def __init__(self, model, kinds, *others, **known):
            simulated.append(len(kinds))
            super().__init__(model, kinds, *others, **known)

    monkeypatch.setattr("boom_mj.diagnosis.partners.Screening", Counted)
    return lambda: [one.candidate.places for one in stages.partners_of(about, (SQUARE,), screening, Clock())], simulated


def test_a_glance_that_tells_spares_simulations(partners: tuple[Partners, list[int]]) -> None:
    found, simulated = partners
    assert {*found()[:2]} == {(HUM.cause,), (RAMP.cause,)}
    assert simulated == [5]  # of nine


@mark.parametrize(
    "told",
    [lambda promise: 1 - promise, lambda promise: 0.0, lambda promise: promise + 0.5],
    ids=["the reverse", "nothing", "more of all"],
)
def test_a_glance_that_does_not_tell_costs_no_partner(
    told: Callable[[float], float], partners: tuple[Partners, list[int]], monkeypatch: MonkeyPatch
) -> None:
    found, simulated = partners
    right, promises = found(), Screening.promises
    monkeypatch.setattr(Screening, "promises", lambda *given: {k: told(v) for k, v in promises(*given).items()})
    assert found() == right
    assert simulated == [5, 5, 9]


@mark.usefixtures("library")
@mark.parametrize("oscillatory", [True, False])
def test_where_fits_are_short_more_partners_are_fitted(oscillatory: bool) -> None:
    about = model((SQUARE, HUM, RAMP), oscillatory=oscillatory)
    screening = Screening(about, everywhere(about.system, ()), [])
    found = stages.partners_of(about, (SQUARE,), screening, Clock())
    few, many = about.budget.partners, about.budget.finalists
    assert len(found) == few if oscillatory else len(found) >= many > few


@mark.usefixtures("library")
@mark.parametrize("better", [True, False])
def test_what_is_fitted_again_counts_once_refined(better: bool, monkeypatch: MonkeyPatch) -> None:
    """Where fits are short a combination is tried from another start; its rough score does not outdo a refined one."""
    about, gaps = model((SQUARE, HUM), oscillatory=False), (9.0, 9.0)
    pair = Candidate((SQUARE, HUM))
    (first,) = stages.fit_all(about, [pair], Clock())
    rough = replace(first, held_out=0.5 * first.held_out)
    done = replace(first, held_out=0.6 * first.held_out)
    monkeypatch.setattr(stages, "_fit_by_promise", lambda *given: [rough])
    monkeypatch.setattr(stages, "_refined", lambda scored, *given: [done] if better else scored)
    assert stages._paired([first], about, [(pair, 1.0)], gaps, Clock()) == [done if better else first]


@mark.usefixtures("library")
def test_what_is_known_of_a_machine_is_not_simulated_again() -> None:
    about = model((SQUARE, HUM))
    kinds = everywhere(about.system, ())

    def screened(kinds: list, **known: Any) -> tuple[Screening, float]:
        before = about.predictor.simulated_s
        return Screening(about, kinds, [], (SQUARE,), **known), about.predictor.simulated_s - before

    whole, cost = screened(kinds)
    near, cheaper = screened(kinds, near=True)
    assert near.columns == approx(whole.columns) and near.follow == approx(whole.follow)
    assert cost >= cheaper + 2 * LASTS  # of two nuisances
    some, first = screened(kinds[:4], near=True)
    rest, second = screened(kinds, near=True, done=some)
    assert rest.columns == approx(near.columns)
    assert first + second <= cheaper + 2 * LASTS  # the machine itself and its square once more


@fixture
def looked(library: None, monkeypatch: MonkeyPatch) -> Callable[..., list[int]]:
    """Number of causes of every leader, or part of one, beside which partners were sought of a machine of three."""
    found, partners_of = list[int](), stages.partners_of

    def counted(about, trunk, *others):
        found.append(len(trunk))
        return partners_of(about, trunk, *others)

    def search(most: int = 3) -> list[int]:
        found.clear()
        true = LATE, HUM, term(Ramp, 2, -0.03)
        answer = diagnose(predictor(true), most=most)
        assert causes(answer) == {effect.cause for effect in true[:most]}
        return list(found)

    monkeypatch.setattr(stages, "partners_of", counted)
    return search


def test_where_a_cause_closes_its_share_no_other_leader_is_looked_at(
    looked: Callable[..., list[int]], monkeypatch: MonkeyPatch
) -> None:
    assert looked() == [1, 2]
    monkeypatch.setattr(stages, "leaps", lambda found, before: False)
    assert looked()[:2] == [1, 1]


def test_where_no_more_may_follow_all_are_looked_at(looked: Callable[..., list[int]]) -> None:
    assert looked(most=2)[:2] == [1, 1]


def test_all_are_screened_where_none_closes_its_share_and_more_may_follow(
    library: None, monkeypatch: MonkeyPatch
) -> None:
    """Of a machine that swings, beside the leader alone."""
    asked, hidden_partners, true = list[int](), stages.hidden_partners, (LATE, HUM, term(Ramp, 2, -0.03))

    def counted(about, trunk, *others):
        asked.append(len(trunk))
        return hidden_partners(about, trunk, *others)

    monkeypatch.setattr(stages, "hidden_partners", counted)
    monkeypatch.setattr(stages, "leaps", lambda found, before: False)
    diagnose(predictor(true), most=2)
    assert not asked
    assert causes(diagnose(predictor(true), most=3)) == {effect.cause for effect in true} and asked == [1]


@mark.parametrize(
    ("after", "goes_on"), [((1.9, 1.9), True), ((2.1, 1.9), False), ((1.9, 2.1), False), ((0.98, 0.98), True)]
)
def test_a_share_is_half_of_what_is_above_noise(after: tuple[float, float], goes_on: bool) -> None:
    found: Any = SimpleNamespace(gaps=after, model=SimpleNamespace(budget=SearchBudget()))
    assert stages.leaps(found, (2.9, 2.9)) == goes_on


@mark.usefixtures("library")
@mark.parametrize("kind", ["boom", "mjcf"])
def test_what_explains_nothing_is_made_simpler_only_where_the_floor_is_never_reached(
    kind: str, monkeypatch: MonkeyPatch
) -> None:
    simplified = list[int]()
    monkeypatch.setattr(stages, "_simplified", lambda scored, *others: simplified.append(len(scored)) or scored)
    answer = diagnose(predictor((SQUARE,), kind=kind, oscillatory=kind == "boom"), without=("square",))
    assert answer.verdict == "unexplained" and bool(simplified) == (kind == "mjcf")


def test_a_leader_is_begun_anew_once(monkeypatch: MonkeyPatch) -> None:
    def scored(name: str, held_out: float) -> Any:
        return SimpleNamespace(fit=SimpleNamespace(candidate=SimpleNamespace(places=(name,))), held_out=held_out)

    one, better, begun = scored("one", 2.0), scored("one", 1.5), set[tuple]()
    monkeypatch.setattr(stages, "begun_anew", lambda leader, *others: better if leader is one else leader)
    assert stages._anew([one], (3.0, 3.0), begun, Clock()) == [better]
    assert stages._anew([one], (3.0, 3.0), begun, Clock()) == [one] and begun == {("one",)}
    assert stages._anew([other := scored("other", 1.8)], (3.0, 3.0), begun, Clock()) == [other]
