"""Which explanation is chosen of those that were scored, and which of them are tried as pairs."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
from pytest import MonkeyPatch, fixture, mark

from boom_mj.diagnosis import decision, stages
from boom_mj.diagnosis.candidate import Candidate
from boom_mj.diagnosis.clock import Clock
from boom_mj.diagnosis.criteria import BOOM, SearchBudget
from boom_mj.diagnosis.decision import choose, solved
from boom_mj.diagnosis.fitting import Fit
from boom_mj.diagnosis.partners import shared
from boom_mj.diagnosis.scoring import Scored
from boom_mj.effects import BOOM_SITES, Effect, effect_library, parse_effect

BUDGET = SearchBudget()
MODEL = SimpleNamespace(criteria=BOOM, budget=BUDGET)
NOMINAL = (12.0, 12.0)
PAYLOAD, CONCRETE, SOFT = "tip_payload:mass=27", "pipe_concrete:fill=0.1", "base_compliance:axes=roll,roll=1e8"
SOFTER = "base_compliance:axes=roll+pitch,roll=1e8,pitch=1e8"


@fixture(autouse=True)
def all_sure(monkeypatch: MonkeyPatch) -> None:
    monkeypatch.setattr(decision, "sure", lambda without, found: True)


def scored(gap: float, *effects: str) -> Scored:
    candidate = Candidate(tuple(map(parse_effect, effects)))
    empty = np.zeros((0, len(candidate.start)))
    fit = Fit(candidate, candidate.start, candidate.effects, empty[:, 0], empty, 0.0)
    return Scored(fit, MODEL, gap, gap, candidate.start)


def one_of(kind: str) -> Effect:
    """An effect where it may be first."""
    return effect_library()[kind](effect_library()[kind].allowed(BOOM_SITES)[0])


def chosen(*found: Scored) -> str | None:
    best = choose(sorted(found, key=lambda j: j.held_out), NOMINAL)
    return best and best.label


def test_a_cause_that_suffices_stands_alone() -> None:
    single, pair = scored(0.9860, PAYLOAD), scored(0.9855, PAYLOAD, SOFT)
    assert solved(NOMINAL, single)
    assert chosen(single, pair) == single.label


@mark.parametrize(
    ("left", "glance", "promised", "looks"),
    [
        (1.005, 0.02, 0.003, True),
        (0.98, 0.02, 0.003, True),
        (0.98, 0.02, 0.002, False),
        (0.98, 0.002, 0.02, False),
    ],
)
def test_beside_what_suffices_another_is_tried_where_one_may_hide(
    monkeypatch: MonkeyPatch, left: float, glance: float, promised: float, looks: bool
) -> None:
    single, pair = scored(left, PAYLOAD), scored(0.97, PAYLOAD, SOFT)
    about = SimpleNamespace(**vars(MODEL), predict=lambda given: given, residual=lambda said: said)
    screening = SimpleNamespace(
        promises=lambda *given: {SOFT: glance}, imitations=lambda *given: ([], 0.0), model=about
    )
    partner = SimpleNamespace(share=promised, starts=[Candidate((parse_effect(SOFT),))])
    monkeypatch.setattr(stages, "partners_of", lambda *given: [partner])
    monkeypatch.setattr(stages, "_paired", lambda found, *given: [pair, *found])
    monkeypatch.setattr(stages, "_simplified", lambda found, *given: found)
    found = stages.combined([replace(single, model=about)], NOMINAL, screening, Clock(), 2)  # type: ignore[arg-type]
    assert (pair in found) == looks


@mark.parametrize(("left", "both"), [(0.9885, True), (0.9889, False)])
def test_a_second_cause_lowers_the_mean_square_by_what_counts(left: float, both: bool) -> None:
    single, pair = scored(0.99, PAYLOAD), scored(left, PAYLOAD, SOFT)
    assert (0.99**2 - left**2 > BOOM.least_gain) == both
    assert chosen(single, pair) == (pair if both else single).label


def test_a_second_cause_that_held_out_data_do_not_tell_is_none(monkeypatch: MonkeyPatch) -> None:
    single, pair = scored(1.02, PAYLOAD), scored(0.97, PAYLOAD, SOFT)
    assert chosen(single, pair) == pair.label
    monkeypatch.setattr(decision, "sure", lambda without, found: False)
    assert chosen(single, pair) == single.label


@mark.parametrize(("left", "all_fitted"), [(1.1, False), (2.0, True)])
def test_what_promises_little_is_fitted_only_where_the_best_leaves_much(
    monkeypatch: MonkeyPatch, left: float, all_fitted: bool
) -> None:
    model = SimpleNamespace(criteria=BOOM, budget=SearchBudget(always=1), facts=SimpleNamespace(oscillatory=True))
    fitted: list[str] = []

    def fit_all(model: object, candidates: list[Candidate], clock: Clock) -> list[Scored]:
        fitted.extend(one.label for one in candidates)
        return [scored(left, PAYLOAD) for _ in candidates]

    monkeypatch.setattr(stages, "fit_all", fit_all)
    promised = [
        (Candidate((parse_effect(text),)), share) for text, share in ((PAYLOAD, 0.9), (SOFT, 0.8), (CONCRETE, 0.1))
    ]
    stages._fit_by_promise(model, promised, 3.0, Clock())
    assert fitted == ["tip_payload", "base_compliance axes roll", *["pipe_concrete"] * all_fitted]


@mark.parametrize(("left", "swings", "nominal"), [(5.0, True, True), (3.0, True, False), (5.0, False, False)])
def test_what_leaves_much_of_what_vibrates_is_no_machine_about_which_to_fit(
    left: float, swings: bool, nominal: bool
) -> None:
    model = SimpleNamespace(criteria=BOOM, budget=BUDGET, facts=SimpleNamespace(oscillatory=swings))
    found = scored(left, PAYLOAD)
    assert stages._about(found, NOMINAL, model) is (model if nominal else found.model)  # type: ignore[arg-type]


def test_a_second_cause_closes_half_of_what_the_first_leaves() -> None:
    single = scored(3.0, PAYLOAD)
    assert chosen(single, scored(2.1, PAYLOAD, SOFT)) == single.label
    assert chosen(single, scored(1.9, PAYLOAD, SOFT)) == "tip_payload + base_compliance axes roll"
    alone = scored(1.9, SOFT)  # either member, wherever it stands among the scored
    assert chosen(single, alone, scored(1.5, PAYLOAD, SOFT)) == alone.label


@mark.parametrize(
    ("alone", "together", "both"),
    [
        (1.42, 1.07, False),  # took 142 of the mean square, of which 1 % may be its own inaccuracy
        (1.42, 1.01, True),  # it does not suffice, with another it does
        (1.01, 1.005, False),  # it suffices
        (1.01, 0.98, True),  # nothing but noise is left
    ],
)
def test_what_may_be_the_firsts_inaccuracy_is_no_second_cause(alone: float, together: float, both: bool) -> None:
    single, pair = scored(alone, PAYLOAD), scored(together, PAYLOAD, CONCRETE)
    assert (solved(NOMINAL, single), solved(NOMINAL, pair)) == (alone == 1.01, together < 1.07)
    assert chosen(single, pair) == (pair if both else single).label


def test_the_simplest_of_causes_that_contain_each_other() -> None:
    assert chosen(scored(1.0, SOFT), scored(0.99, SOFTER)) == "base_compliance axes roll"
    assert chosen(scored(2.0, SOFT), scored(0.99, SOFTER)) == "base_compliance axes roll+pitch"


def test_nothing_is_chosen_that_does_not_help() -> None:
    assert chosen() is None
    assert chosen(scored(12.0, PAYLOAD)) is None


def test_a_cause_that_training_or_held_out_data_do_not_show_is_none() -> None:
    found = scored(0.98, PAYLOAD)
    assert chosen(found) == found.label
    assert chosen(replace(found, train=12.0)) is None
    assert chosen(replace(found, held_out=12.0)) is None


def test_the_best_of_what_was_alone_are_tried_beside_a_leader_but_not_its_own_causes() -> None:
    alone = [scored(size, text) for size, text in ((1.4, PAYLOAD), (1.8, SOFTER), (2.0, SOFT), (2.8, CONCRETE))]
    found = [*alone, scored(3.0, "end_hose:mass=20")]
    tried = [pair.label for pair, _ in shared(found[0].fit.effects, found)]
    assert tried == ["tip_payload + base_compliance axes roll+pitch", "tip_payload + base_compliance axes roll"]
    assert len(tried) == BUDGET.singles_beside
    beside = [pair.label for pair, _ in shared(found[1].fit.effects, found)]
    assert beside == [
        "base_compliance axes roll+pitch + tip_payload",
        "base_compliance axes roll+pitch + pipe_concrete",
    ]


def test_beside_the_best_few_the_best_of_other_kinds_are_fitted() -> None:
    shares = (
        (PAYLOAD, 0.9),
        (SOFT, 0.8),
        (SOFTER, 0.7),
        (CONCRETE, 0.5),
        ("end_hose:mass=20", 0.3),
        ("base_tilt", 0.2),
    )
    few = [SimpleNamespace(candidate=Candidate((parse_effect(PAYLOAD),)), share=1.0)] * BUDGET.finalists
    more = [SimpleNamespace(candidate=Candidate((parse_effect(text),)), share=share) for text, share in shares]
    found = stages.shortlist(MODEL, [*few, *more])  # type: ignore[arg-type]
    assert found == [*few, more[1], more[3]]  # each kind once, and what promises more than a share of the best
    kinds = ("tip_payload", "base_compliance", "pipe_concrete", "end_hose", "base_tilt", "imu_bias", "marker_slip")
    alike = [SimpleNamespace(candidate=Candidate((effect,)), share=0.9) for effect in map(one_of, kinds)]
    assert len(stages.shortlist(MODEL, [*few, *alike])) == BUDGET.finalists + BUDGET.kinds_beyond  # type: ignore[arg-type]


def test_what_leaders_leave_is_refined_and_what_fits_training_best(monkeypatch: MonkeyPatch) -> None:
    about, asked = SimpleNamespace(**vars(MODEL), facts=SimpleNamespace(oscillatory=True)), list[str]()

    def refine(one: Scored, as_built: tuple[float, float], clock: Clock) -> Scored:
        asked.append(one.label)
        return one

    def fitted(train: float, held_out: float, *effects: str) -> Scored:
        return replace(scored(held_out, *effects), train=train, model=about)

    monkeypatch.setattr(stages, "refine", refine)
    leader, second, third, trained = (
        fitted(5.0, 2.0, PAYLOAD), fitted(4.0, 2.5, CONCRETE), fitted(6.0, 2.9, SOFT), fitted(1.1, 8.0, SOFTER),
    )  # fmt: skip
    stages._refined([leader, second, third, trained], NOMINAL, Clock())
    assert asked == [leader.label, second.label, trained.label]
    asked.clear()
    stages._refined([replace(leader, train=1.1), trained], NOMINAL, Clock())
    assert asked == [leader.label]
