"""What answers say: shares, words, how a machine was built and when it changed; on a machine known by algebra."""

from dataclasses import replace

import numpy as np
from algebra import (
    BLOCK_S,
    HUM,
    RAMP,
    SAID,
    SQUARE,
    TIME,
    Algebra,
    Gust,
    Hum,
    Offset,
    Square,
    causes,
    found,
    model,
    off,
    recorded,
    sweep,
    swing,
    term,
)
from pytest import approx, mark

from boom_mj.diagnosis import diagnose
from boom_mj.diagnosis.budget import gap_budget, metric
from boom_mj.diagnosis.candidate import Candidate
from boom_mj.diagnosis.healthy import as_built
from boom_mj.diagnosis.named import closure_of
from boom_mj.diagnosis.scoring import Scored
from boom_mj.diagnosis.sentences import rival, sentence
from boom_mj.diagnosis.steps import channel_steps
from boom_mj.diagnosis.watch import watch
from boom_mj.estimation.latent_input import NONE
from boom_mj.systems.as_built import AsBuilt
from boom_mj.systems.predictor import Predictor, dataset_of
from boom_mj.systems.system import Nuisance


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
