"""The whole search, on a machine whose answers are known by algebra."""

from collections.abc import Callable

import numpy as np
from algebra import (
    BLOCK_S,
    HUM,
    LATE,
    MIDDLE,
    RAMP,
    SAID,
    SQUARE,
    TIME,
    WEAK,
    WEAKER,
    Broken,
    Gust,
    Hum,
    Likeness,
    Ramp,
    Square,
    causes,
    found,
    lull,
    model,
    off,
    predictor,
    rest,
    swing,
    term,
)
from pytest import MonkeyPatch, approx, fixture, mark

from boom_mj.diagnosis import Diagnosis, diagnose, linearisation
from boom_mj.diagnosis.candidate import everywhere
from boom_mj.diagnosis.clock import Clock
from boom_mj.diagnosis.criteria import BOOM
from boom_mj.diagnosis.screening import Screening
from boom_mj.effects import Effect

Library = Callable[..., None]


@mark.usefixtures("library")
@mark.parametrize("oscillatory", [True, False])
def test_a_healthy_machine_has_no_cause(oscillatory: bool) -> None:
    answer = found(oscillatory=oscillatory)
    assert (answer.verdict, answer.best, answer.ties, answer.skipped) == ("consistent", None, (), ())
    assert answer.odds.none > 0.9 and answer.residual is answer.as_built and not answer.solved


@mark.usefixtures("library")
@mark.parametrize("oscillatory", [True, False])
@mark.parametrize(
    "true",
    [(SQUARE,), (LATE,), (SQUARE, HUM), (LATE, WEAK), (LATE, WEAK, WEAKER)],
    ids=["linear", "not linear", "two", "a weak one beside", "two more beside"],
)
def test_causes_are_found_with_their_sizes(true: tuple[Effect, ...], oscillatory: bool) -> None:
    answer = found(*true, oscillatory=oscillatory)
    assert answer.verdict == "explained" and answer.solved and not answer.ties
    assert causes(answer) == {effect.cause for effect in true}
    assert all(abs(off(answer, effect)) < 3.5 for effect in true)
    assert max(answer.best.gaps) < BOOM.explained_gap and all(answer.sure)
    assert answer.closure.value == approx(1.0, abs=0.01) and answer.simplest is None
    odds = answer.odds
    assert sum(odds.explanations) + odds.outside_library + odds.none + odds.combination == approx(1.0)
    right = [p for p, one in zip(odds.explanations, answer.scored) if one is answer.best]
    assert right == [max(odds.explanations)] and right[0] > 0.8


@mark.usefixtures("library")
@mark.parametrize("true", [(SQUARE,), (LATE,), (SQUARE, HUM), (LATE, HUM)])
def test_a_machine_of_a_file_is_explained_as_well(true: tuple[Effect, ...]) -> None:
    answer = found(*true, kind="mjcf", oscillatory=False)
    assert answer.verdict == "explained" and causes(answer) == {effect.cause for effect in true}
    assert all(abs(off(answer, effect)) < 3.5 for effect in true)


@mark.usefixtures("library")
def test_a_size_is_as_sure_as_noise_lets_it_be() -> None:
    answer = found(SQUARE)
    shape = swing(TIME).reshape(-1, int(BLOCK_S / 0.02)).mean(axis=1) ** 2  # in blocks, hardly another
    clean = shape - shape.mean()  # the offset follows
    expected = SAID / np.sqrt(BLOCK_S / 0.02) / np.linalg.norm(clean) / SQUARE.declared["size"].typical
    assert answer.best.deviation == approx([expected], rel=0.2)


@mark.usefixtures("library")
def test_three_together_are_sought_where_they_are_asked_for() -> None:
    true = SQUARE, HUM, RAMP
    answer = found(*true)
    assert answer.verdict == "unexplained" and causes(answer) < {effect.cause for effect in true}
    answer = found(*true, most=3)
    assert answer.verdict == "explained" and causes(answer) == {effect.cause for effect in true}


def test_what_the_data_do_not_tell_apart_ties(library: Library) -> None:
    library(Square, Likeness, Ramp)
    answer = found(SQUARE)
    assert answer.verdict == "ambiguous" and answer.solved
    named = [one.fit.effects[0].id for one in (answer.best, *answer.ties)]
    assert sorted(named) == ["likeness", "square"] and not any(answer.sure)


@mark.usefixtures("library")
@mark.parametrize("oscillatory", [True, False])
def test_what_the_library_does_not_hold_is_not_explained(oscillatory: bool) -> None:
    answer = found(SQUARE, without=("square",), oscillatory=oscillatory)
    assert answer.verdict == "unexplained" and not answer.solved
    assert answer.odds.outside_library > 0.5 and answer.odds.none == 0
    assert all("square" not in {e.id for e in one.fit.effects} for one in answer.scored)


@mark.usefixtures("library")
def test_two_weak_causes_beside_one_that_suffices_are_chosen_together() -> None:
    true = LATE, WEAK, term(Ramp, 2, -0.004)  # either of them leaves what the first, being so large, may leave
    answer = found(*true)
    assert answer.verdict == "explained" and causes(answer) == {effect.cause for effect in true}


@mark.usefixtures("library")
def test_what_explains_half_is_named_in_part() -> None:
    answer = found(LATE, term(Square, 2, 0.1), without=("square",), kind="mjcf", oscillatory=False)
    assert answer.verdict == "partial" and causes(answer) == {LATE.cause} and answer.sure == (True,)


@mark.usefixtures("library")
def test_what_only_held_out_recordings_show_trains_in_part() -> None:
    answer = found(SQUARE, motions=(rest, swing))
    assert answer.model.data.extended == {1} and answer.verdict == "explained"
    assert causes(answer) == {SQUARE.cause}


@mark.usefixtures("library")
def test_of_two_held_out_the_one_that_shows_more_trains_in_part() -> None:
    answer = found(SQUARE, motions=(rest, lull, swing))
    assert answer.model.data.extended == {2} and answer.not_trained == {}
    assert answer.verdict == "explained" and causes(answer) == {SQUARE.cause}


def test_a_cause_with_which_nothing_moves_is_none(library: Library) -> None:
    library(Square, Broken)
    answer = found(SQUARE)
    assert answer.verdict == "explained" and causes(answer) == {SQUARE.cause}


@mark.usefixtures("library")
def test_what_a_coarse_simulation_gets_wrong_is_no_gap() -> None:
    answer = found(coarseness=0.02)
    assert answer.verdict == "consistent" and answer.fidelity_alone > 0.9
    wrong = answer.model.mean_error[answer.model.data.channel_of == 0]
    assert np.abs(wrong).max() == approx(MIDDLE.step * 0.02, rel=0.1)


@mark.usefixtures("library")
def test_without_time_all_that_is_left_out_is_said() -> None:
    answer = diagnose(predictor((SQUARE, HUM)), clock=Clock(0.0))
    assert answer.skipped == ("the library",) and answer.best is None and answer.verdict == "unexplained"


@mark.usefixtures("library")
def test_the_stages_are_said_and_what_is_known_is_kept_after_each() -> None:
    said, kept = list[str](), list[Diagnosis]()
    answer = diagnose(predictor((SQUARE, HUM)), clock=Clock(tell=said.append), keep=kept.append)
    assert [line.split()[0] for line in said[:4]] == ["fidelity", "gap", "10", "fitting"]
    assert any(line.startswith("screening beside") for line in said)
    assert any(line.startswith("combinations: ") for line in said)
    assert [one.verdict for one in kept] == ["unexplained"] * 2
    assert kept[-1].best is not None and kept[-1].best.held_out > answer.best.held_out


@mark.usefixtures("library")
def test_a_candidate_promises_what_least_squares_would_close() -> None:
    about = model((SQUARE, HUM))
    raw, train = about.residual(about.base), about.data.train
    screening = Screening(about, everywhere(about.system), ())
    promised = {one.candidate.effects[0].cause: one for one in screening.rank(raw)}
    offsets = about.posterior.basis.whole[train]

    def left(columns: np.ndarray) -> float:
        stacked = np.vstack([columns, np.eye(columns.shape[1])[:2]])  # the prior of offsets
        target = np.r_[raw[train], np.zeros(2)]
        return float(np.sum((target - stacked @ np.linalg.lstsq(stacked, target)[0]) ** 2))

    before = left(offsets)
    for true in (SQUARE, HUM, RAMP):
        (moved,) = about.residuals([(true,)])
        column = (raw - moved)[train][:, None]
        assert promised[true.cause].share == approx(1 - left(np.hstack([offsets, column])) / before, abs=0.01)
    assert next(iter(promised)) == HUM.cause
    for true in (SQUARE, HUM):
        (effect,) = promised[true.cause].candidate.effects
        assert effect.values["size"] == approx(true.values["size"], rel=0.05)


@mark.usefixtures("library")
def test_beside_a_cause_others_promise_what_it_leaves() -> None:
    about = model((SQUARE, HUM))
    screening = Screening(about, everywhere(about.system), ())
    left = about.residual(*about.predict([(SQUARE,)]))
    promise = screening.promises((SQUARE,), left)
    assert max(promise, key=promise.__getitem__) == HUM.cause and promise[HUM.cause] > 0.9
    assert SQUARE.cause not in promise
    first, site = next(iter(screening.beside((SQUARE,), left, ())))
    assert (first.id, site.key) == HUM.cause


@fixture
def asked(library: Library, monkeypatch: MonkeyPatch) -> list[tuple[Effect, ...]]:
    """Hypotheses whose inputs that no log tells were asked for."""
    library(Square, Hum, Gust)
    heard = list[tuple[Effect, ...]]()

    def latent_input_of(predictor: object, effects: tuple[Effect, ...], *others: object) -> None:
        heard.append(effects)

    monkeypatch.setattr(linearisation, "latent_input_of", latent_input_of)
    return heard


@mark.parametrize(("true", "times"), [(SQUARE, 0), (LATE, 2)], ids=["another suffices", "none does"])
def test_inputs_that_no_log_tells_are_looked_for_where_nothing_else_suffices(
    asked: list[tuple[Effect, ...]], true: Effect, times: int
) -> None:
    about = model((true,))
    Screening(about, everywhere(about.system), ()).rank(about.residual(about.base))
    assert [effects[0].id for effects in asked] == ["gust"] * times  # at either sensor


def test_only_what_has_an_input_that_no_log_tells_is_asked_for_it(asked: list[tuple[Effect, ...]]) -> None:
    gust, about = term(Gust, 1, 0.05), model((SQUARE,))
    Screening(about, everywhere(about.system), (), (gust,)).rank(about.residual(*about.predict([(gust,)])))
    assert [[effect.cause for effect in effects] for effects in asked] == [[gust.cause, term(Gust, 2, 0.05).cause]]
