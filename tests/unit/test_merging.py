"""One cause in the place of several: what all sensors say alike, met as what each of them says."""

from dataclasses import replace

import numpy as np
from algebra import HUM, SITES, SQUARE, Common, Cube, Hum, Offset, Ramp, Square, Term, predictor, term
from pytest import MonkeyPatch, approx, mark

from boom_mj.diagnosis import stages
from boom_mj.diagnosis.candidate import Candidate
from boom_mj.diagnosis.clock import Clock
from boom_mj.diagnosis.decision import choose, solved
from boom_mj.diagnosis.linearisation import linearise
from boom_mj.diagnosis.merging import likes_of, wholes_of
from boom_mj.diagnosis.scoring import Scored
from boom_mj.diagnosis.screening import Screening
from boom_mj.effects import Effect
from boom_mj.estimation.bootstrap import gap

Array = np.ndarray
Gaps = tuple[float, float]


class Alone(Term):
    """What one sensor says of what all say alike."""

    id = "alone"

    def shape(self, time: Array, angle: Array) -> Array:
        return np.cos(0.7 * time)


class Dented(Term):
    """A square with a dent."""

    id = "dented"
    confused_with = ("square",)

    def shape(self, time: Array, angle: Array) -> Array:
        return angle**2 * (1 + 0.3 * np.sin(time))


KINDS = [(kind, site) for kind in (Square, Cube, Ramp, Hum, Common, Alone, Dented) for site in SITES]
PARTS = term(Alone, 1, 0.05), term(Alone, 2, 0.05)
WHOLE = term(Common, 1, 0.05)


def explained(true: tuple[Effect, ...], by: tuple[Effect, ...], kind: str = "boom") -> tuple[Scored, Screening, Gaps]:
    """A machine that has some effects, fitted with others; the screening and the gaps of it as built."""
    model = linearise(predictor(true, kind=kind))
    as_built = model.clean(raw := model.residual(model.base))
    gaps = gap(as_built, model.data.train), gap(as_built, model.data.held_out)
    screening = Screening(model, KINDS, [])
    screening.rank(raw)
    (found,) = stages.fit_all(model, [Candidate(by)], Clock())
    return found, screening, gaps


@mark.parametrize("beside", [(), (SQUARE,), (SQUARE, HUM)])
def test_what_does_what_parts_do_is_tried_and_chosen(beside: tuple[Effect, ...]) -> None:
    parts, screening, gaps = explained((WHOLE, *beside), (*PARTS, *beside))
    promised = wholes_of(parts, screening, gaps[0])
    assert {one.places for one in promised} <= {
        Candidate((term(Common, sensor, 1.0), *beside)).places for sensor in (1, 2)
    }
    assert promised and promised[0].effects[-1].values["size"] == approx(0.05, rel=0.02)
    scored = stages._merged([parts], gaps, screening, Clock())
    chosen = choose(scored, gaps)
    assert chosen and {e.id for e in chosen.fit.effects} == {"common", *(e.id for e in beside)}
    assert parts in scored


def test_parts_of_other_sizes_are_no_whole() -> None:
    true = term(Alone, 1, 0.05), term(Alone, 2, -0.02)
    parts, screening, gaps = explained(true, PARTS)
    assert wholes_of(parts, screening, gaps[0]) == []
    assert stages._merged([parts], gaps, screening, Clock()) == [parts]


def test_a_cause_is_not_put_in_the_place_of_itself() -> None:
    """Beside a hum that does nothing the square alone is a simpler explanation, and no other one."""
    parts, screening, gaps = explained((SQUARE,), (SQUARE, term(Hum, 2, 1e-4)))
    assert wholes_of(parts, screening, gaps[0]) == []


def test_what_does_not_suffice_is_left_as_it_is() -> None:
    parts, screening, gaps = explained((WHOLE, term(Offset, 1, 0.0), term(Cube, 2, 0.4)), PARTS)
    assert parts.train > 2
    assert stages._merged([parts], gaps, screening, Clock()) == [parts]


@mark.parametrize(("true", "by"), [(Square, Dented), (Dented, Square)])
def test_a_cause_gives_way_to_the_one_it_is_confused_with_at_its_place(true: type[Term], by: type[Term]) -> None:
    cause = term(true, 1, 0.5)
    first, screening, gaps = explained((cause, HUM), (term(by, 1, 0.5), HUM))
    assert [one.places for one in likes_of(first, screening)] == [Candidate((HUM, cause)).places]
    leader, *others = stages._swapped([first], gaps, screening, Clock())
    assert leader.fit.candidate.places == Candidate((cause, HUM)).places and others == [first]
    assert leader.train < 1.05 < first.train
    first, screening, _ = explained((cause, HUM), (term(by, 1, 0.5), HUM), kind="mjcf")
    large = (1e5, 1e5)  # of a gap so large it suffices as well
    assert solved(large, first) and stages._swapped([first], large, screening, Clock())[0].train < 1.05


@mark.parametrize("known", [False, True])
def test_causes_of_a_boom_that_leave_more_than_noise_give_way(known: bool) -> None:
    """To what was fitted roughly before, too."""
    first, screening, gaps = explained((SQUARE, HUM), (term(Dented, 1, 0.5), HUM))
    assert gaps[0] > 2 and 1.01 < first.train < 1 + 0.25 * (gaps[0] - 1)
    rough = replace(first, fit=replace(first.fit, candidate=Candidate((HUM, SQUARE))), held_out=2 * first.held_out)
    leader, *_ = stages.combined([first, *[rough] * known], gaps, screening, Clock(), 2)
    assert leader.fit.candidate.places == Candidate((SQUARE, HUM)).places and leader.refined
    assert max(leader.gaps) < 1.05


def test_a_cause_gives_way_to_its_like_at_another_place() -> None:
    """What all sensors say alike is so by whatever name; a square of one sensor is none of another's."""
    found, screening, _ = explained((WHOLE, SQUARE), (WHOLE, SQUARE))
    places = {one.places for one in likes_of(found, screening)}
    elsewhere = Candidate((SQUARE, term(Common, 2, 1.0)))
    assert elsewhere.places in places
    assert not any(("square", (("sensor", 2),)) in there for there in places)


def test_what_changes_nothing_nothing_is_like() -> None:
    found, screening, _ = explained((SQUARE,), (SQUARE,))
    alike, square = screening.imitations((), np.zeros(len(found.fit.residual)), found.model, found.fit.jacobian)
    assert square == 0 and {one.share for one in alike} == {0.0}


def test_what_leaves_noise_and_what_no_time_is_left_for_is_not_swapped() -> None:
    first, screening, gaps = explained((SQUARE, HUM), (SQUARE, HUM))
    assert stages._swapped([first], gaps, screening, Clock()) == [first]
    first, screening, gaps = explained((SQUARE, HUM), (term(Dented, 1, 0.5), HUM))
    assert stages._swapped([first], gaps, screening, over := Clock(0.0)) == [first]
    assert over.skipped == ("causes like those found",)


@mark.parametrize(("chosen", "searched"), [("both", []), ("alone", [2, 3])])
def test_a_search_ends_where_what_would_be_chosen_suffices(
    chosen: str, searched: list[int], monkeypatch: MonkeyPatch
) -> None:
    """A leader that suffices but is no surer than one that does not has not decided."""
    alone, screening, gaps = explained((SQUARE, HUM), (SQUARE,), "mjcf")
    both, *_ = explained((SQUARE, HUM), (SQUARE, HUM), "mjcf")
    assert solved(gaps, both) and not solved(gaps, alone)
    asked = list[int]()
    monkeypatch.setattr(stages, "choose", lambda scored, gaps: {"both": both, "alone": alone}[chosen])
    monkeypatch.setattr(stages, "_combine", lambda scored, size, *rest: asked.append(size) or scored)
    stages.combined([both, alone], gaps, screening, Clock(), most=4)
    assert asked == searched


def test_without_time_nothing_is_merged() -> None:
    parts, screening, gaps = explained((WHOLE,), PARTS)
    over = Clock(0.0)
    assert stages._merged([parts], gaps, screening, over) == [parts]
    assert over.skipped == ("one cause in the place of several",)
