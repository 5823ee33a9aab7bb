"""Partners of a leader: a glance that tells spares simulations, and one that does not costs no partner."""

from collections.abc import Callable
from typing import Any

from algebra import HUM, RAMP, SQUARE, TIME, model
from pytest import MonkeyPatch, approx, fixture, mark

from boom_mj.diagnosis import stages
from boom_mj.diagnosis.candidate import everywhere
from boom_mj.diagnosis.clock import Clock
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

    monkeypatch.setattr(stages, "Screening", Counted)
    return lambda: [one.candidate.places for one in stages._partners(about, (SQUARE,), screening, Clock())], simulated


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
