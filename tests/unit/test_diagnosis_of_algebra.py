"""The whole search, on a machine whose answers are known by algebra."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from algebra import (
    BLOCK_S,
    LIBRARY,
    MIDDLE,
    SAID,
    TIME,
    Algebra,
    Broken,
    Cube,
    Gust,
    Hum,
    Late,
    Likeness,
    Offset,
    Ramp,
    Square,
    Term,
    lull,
    model,
    predictor,
    recorded,
    rest,
    sweep,
    swing,
    term,
)
from pytest import MonkeyPatch, approx, fixture, mark

from boom_mj.diagnosis import Diagnosis, candidate, diagnose, linearisation
from boom_mj.diagnosis.budget import gap_budget, metric
from boom_mj.diagnosis.candidate import Candidate, everywhere
from boom_mj.diagnosis.clock import Clock
from boom_mj.diagnosis.criteria import BOOM
from boom_mj.diagnosis.healthy import as_built
from boom_mj.diagnosis.named import closure_of
from boom_mj.diagnosis.scoring import Scored
from boom_mj.diagnosis.screening import Screening
from boom_mj.diagnosis.sentences import rival, sentence
from boom_mj.diagnosis.steps import channel_steps
from boom_mj.diagnosis.watch import watch
from boom_mj.effects import Effect
from boom_mj.estimation.latent_input import NONE
from boom_mj.systems.as_built import AsBuilt
from boom_mj.systems.predictor import Predictor, dataset_of
from boom_mj.systems.system import Nuisance

SQUARE, HUM, RAMP, LATE = term(Square, 1, 0.05), term(Hum, 2, 0.05), term(Ramp, 2, -0.1), term(Late, 1, 0.3)
WEAK, WEAKER = term(Hum, 2, 0.003), term(Ramp, 2, -0.002)
Library = Callable[..., None]


@fixture
def library(monkeypatch: MonkeyPatch) -> Library:
    """Lets only some effects compete."""

    def hold(*kinds: type[Term]) -> None:
        held = {name: kind for name, kind in LIBRARY.items() if kind in (Offset, *kinds)}
        monkeypatch.setattr(candidate, "effect_library", lambda: held)

    hold(Square, Cube, Ramp, Hum, Late)
    return hold


def found(*effects: Effect, without: tuple[str, ...] = (), most: int | None = None, **machine) -> Diagnosis:
    return diagnose(predictor(effects, **machine), without, most=most)


def causes(answer: Diagnosis) -> set:
    assert answer.best is not None
    return {effect.cause for effect in answer.best.fit.effects}


def off(answer: Diagnosis, true: Effect) -> float:
    """By how many of its standard deviations the size of a cause is off."""
    assert answer.best is not None
    (k,) = [k for k, effect in enumerate(answer.best.fit.effects) if effect.cause == true.cause]
    scale = true.declared["size"].typical
    return (answer.best.fit.effects[k].values["size"] - true.values["size"]) / scale / answer.best.deviation[k]


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
def test_shares_of_the_gap_are_those_of_the_shapes() -> None:
    budget = found(SQUARE, HUM).budget
    noise = SAID / np.sqrt(BLOCK_S / 0.02)
    square = np.var(sweep(TIME) ** 2) * SQUARE.values["size"] ** 2 / noise**2 / 2  # one of two sensors
    hum = 0.5 * HUM.values["size"] ** 2 / noise**2 / 2
    whole = 1 + square + hum
    first, second = sorted(share.value for share in budget.shares)
    assert [first, second] == approx(sorted([square / whole, hum / whole]), rel=0.1)
    assert first + second + budget.remainder.value + budget.floor.value == approx(1.0)


@mark.usefixtures("library")
def test_shares_are_of_one_noise_model() -> None:
    answer = found(SQUARE, HUM)
    own = answer.best.model
    loud = own.with_noise(replace(own.noise, weight=own.noise.weight / 2))
    twice = replace(answer.best, model=loud, fit=replace(answer.best.fit, residual=answer.best.fit.residual / 2))
    shares, said = ([share.value for share in budget.shares] for budget in (answer.budget, gap_budget(twice)))
    assert said == approx(shares, rel=0.01)


def test_what_no_log_tells_counts_beside_effects_that_have_none() -> None:
    about = model((SQUARE,))
    windy = about.with_noise(replace(about.noise, latent=NONE))
    assert metric(windy)((term(Gust, 1, 0.05), SQUARE)) is windy
    assert metric(windy)((SQUARE,)).latent is metric(windy)(()).latent is None
    assert metric(about)((SQUARE,)) is about


@mark.usefixtures("library")
def test_what_changed_is_as_unsure_as_what_it_changes() -> None:
    healthy, later = (
        [recorded((term(Square, 1, size),), motion, seed + k) for k, motion in enumerate((swing, sweep))]
        for seed, size in ((1, 0.05), (5, 0.15))
    )
    built = as_built(Algebra(), healthy)
    answer, sure = (
        diagnose(Predictor(machine, dataset_of(machine, later, 1)))
        for machine in (built, AsBuilt(built.system, built.built))
    )
    assert causes(answer) == {SQUARE.cause} and abs(off(answer, term(Square, 1, 0.1))) < 3.5
    assert answer.best.deviation == approx(np.hypot(sure.best.deviation, built.deviations[SQUARE.cause, "size"]))
    assert answer.best.deviation > 1.2 * sure.best.deviation


class Individual(Algebra):
    """Machines of whose first sensor the offset scatters a hundred times as much, as long as it is not known."""

    def individual(self) -> tuple[Nuisance, ...]:
        first, second = self.nuisances()
        return replace(first, deviation=100 * first.deviation), second


@mark.usefixtures("library")
def test_how_a_machine_was_built_is_what_healthy_recordings_say_of_it() -> None:
    first, second = term(Offset, 1, 0.8), term(Offset, 2, 0.02)
    healthy = [recorded((first, second), motion, seed) for seed, motion in enumerate((swing, sweep))]
    built = as_built(Individual(), healthy)
    sizes = {effect.cause: effect.values["size"] for effect in built.built}
    deviation = SAID / np.sqrt(2 * 0.6 * len(TIME))  # of the first part of each recording
    assert sizes[first.cause] == approx(0.8, abs=4 * deviation)
    assert built.deviations[first.cause, "size"] * first.declared["size"].typical == approx(deviation, rel=0.1)
    usual, known = built.nuisances()
    assert usual == Individual().nuisances()[1]  # a sensor may be set anew
    (effect,) = known.hypothesis
    assert effect.cause == first.cause and known.deviation * effect.values["size"] == approx(deviation, rel=0.1)
    later = [recorded((first, second, SQUARE), motion, 5 + seed) for seed, motion in enumerate((swing, sweep))]
    answer = diagnose(Predictor(built, dataset_of(built, later, 1)))
    assert answer.verdict == "explained" and causes(answer) == {SQUARE.cause}


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
    first, site = screening.beside((SQUARE,), left)[0]
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


@mark.usefixtures("library")
def test_steps_go_from_the_data_sheet_to_noise() -> None:
    first, second = channel_steps(found(SQUARE), ("training", "held out"))[::2][:2]
    assert (first.log, first.channel, second.log) == ("training", "first", "held out")
    assert first.data_sheet > 2 and first.as_built > 1.5 and not first.worse
    assert first.with_causes == approx(1.0, abs=4 * first.uncertainty)


@mark.usefixtures("library")
def test_a_gap_is_said_to_lie_somewhere_where_there_is_one() -> None:
    shown, weak = found(SQUARE), found(term(Hum, 2, 0.002))
    assert sentence(shown).startswith("Square at sensor 1 (size 0.0") and "Without it, it is seen" in sentence(shown)
    assert weak.verdict == "explained" and "shows within noise" in sentence(weak) and "Without it" not in sentence(weak)


@mark.usefixtures("library")
def test_every_candidate_that_lost_is_told_why() -> None:
    answer = found(SQUARE, HUM)
    whys = {one.label: rival(answer, one)["why_not"] for one in answer.scored if one is not answer.best}
    lost = next(one for one in answer.scored if one.label == "square sensor 1")
    share = f"closes {closure_of(answer, lost):.0%} of the held-out gap"
    assert whys[lost.label] == f"{share}, {answer.best.label} 100%"

    def why(change: Scored) -> str:
        scored = tuple(change if one is lost else one for one in answer.scored)
        return rival(replace(answer, scored=scored), change)["why_not"]

    more = Candidate((SQUARE, HUM, RAMP))
    larger = replace(lost, fit=replace(lost.fit, candidate=more, effects=more.effects))
    assert why(larger) == f"{share}: no better than {answer.best.label} alone"
    better = replace(lost, train=lost.held_out / 1.2)
    assert "fits the training data better" in why(better)
    assert "fits the training data better" not in why(replace(lost, train=lost.held_out / 1.05))
    assert why(replace(lost, train=30.0, held_out=30.0)).startswith("fits no better at any size")


@mark.usefixtures("library")
def test_a_machine_that_changes_is_told_from_then_on() -> None:
    healthy = [recorded((), motion, seed) for seed, motion in enumerate((swing, sweep))]
    later = [recorded(effects, swing, 7 + k) for k, effects in enumerate([(), (), (SQUARE,), (SQUARE,)])]
    answer = watch(Algebra(), healthy, later)
    assert [state.changed for state in answer.logs] == [False, False, True, True]
    assert answer.since == ("log 9", 0.0) and answer.found is not None and answer.found.verdict == "explained"
    assert [state.group for state in answer.logs[2:]] == ["first", "first"]
    for state in answer.logs[2:]:
        (effect,) = state.effects
        assert (effect["id"], effect["location"]) == ("square", {"sensor": 1})
        size = effect["parameters"]["size"]
        assert size["low"] < SQUARE.values["size"] < size["high"]


@mark.usefixtures("library")
def test_a_machine_that_stays_as_it_was_raises_no_alarm() -> None:
    logs = [recorded((), motion, 20 + seed) for seed, motion in enumerate((swing, sweep, swing, sweep))]
    answer = watch(Algebra(), logs[:2], logs[2:])
    assert answer.since is None and answer.found is None and answer.document()["verdict"] == "consistent"
