"""Scoring by answers made up for the purpose: every rule has one that passes and one that does not."""

import json
from dataclasses import replace
from hashlib import sha256
from pathlib import Path

import numpy as np
import pytest

from boom_mj.blind import confusion_svg, html_page, markdown_page, pooled, score
from boom_mj.blind.figures import figures, held, wilson
from boom_mj.blind.grading import NO_ANSWER, Outcome, errors_of, judge_case, twins
from boom_mj.errors import InputError


def effect(name: str, location: dict | None = None, **values: float) -> dict:
    return {"id": name, "location": location or {}, "parameters": values}


def truth(kind: str, *effects: dict) -> dict:
    return {"class": kind, "effects": list(effects), "visibility": 3.0}


def answer(verdict: str, *effects: dict, ties: tuple[str, ...] = (), closure: float = 0.96) -> dict:
    named = [
        {**e, "parameters": {k: {"value": v, "low": 0.9 * v, "high": 1.1 * v} for k, v in e["parameters"].items()}}
        for e in effects
    ]
    tie = [[{"id": name} for name in (*(e["id"] for e in effects), *ties)]] if ties else []
    told = {"verdict": verdict, "sentence": "", "effects": named, "ties": tie, "gap": {"closure": closure}}
    return {**told, "wall_s": 50.0}


SOFT, STIFF = (effect("link_stiffness", {"link": k, "axis": "v"}, factor=0.9) for k in (3, 4))
HEAVY, TILT = effect("tip_payload", mass=40.0), effect("base_tilt", roll=0.01)
STRANGE = effect("camera_scale", share=0.01)


@pytest.mark.parametrize(
    ("sealed", "told", "right", "placed"),
    [
        (truth("single", SOFT), answer("explained", SOFT), True, True),
        (truth("single", SOFT), answer("explained", STIFF), True, False),
        (truth("single", SOFT), answer("explained", HEAVY), False, False),
        (truth("single", SOFT), answer("explained", SOFT, HEAVY), False, False),
        (truth("single", SOFT), answer("ambiguous", HEAVY, ties=("link_stiffness",)), False, False),
        (truth("single", SOFT), answer("consistent"), False, False),
        (truth("none"), answer("consistent"), True, True),
        (truth("none"), answer("explained", TILT), False, False),
        (truth("none"), answer("unexplained"), False, False),
        (truth("pair", SOFT, HEAVY), answer("explained", HEAVY, SOFT), True, True),
        (truth("pair", SOFT, HEAVY), answer("explained", HEAVY, STIFF), True, False),
        (truth("pair", SOFT, HEAVY), answer("explained", HEAVY), False, False),
        (truth("withheld", HEAVY), answer("unexplained"), True, True),
        (truth("withheld", HEAVY), answer("ambiguous", TILT, ties=("end_hose",)), True, True),
        (truth("withheld", HEAVY), answer("ambiguous", TILT, ties=("wind",)), False, False),
        (truth("withheld", HEAVY), answer("partial", TILT, ties=("end_hose",)), False, False),
        (truth("withheld", HEAVY), answer("explained", effect("end_hose", mass=30.0)), False, False),
        (truth("withheld", HEAVY), answer("consistent"), False, False),
        (truth("stranger", STRANGE), answer("unexplained"), True, True),
        (truth("stranger", STRANGE), answer("explained", effect("camera_pose")), False, False),
        (truth("several", SOFT, HEAVY, TILT), answer("explained", TILT, HEAVY, SOFT), True, True),
        (truth("several", SOFT, HEAVY, TILT), answer("partial", TILT, HEAVY), False, False),
        (truth("clutter", SOFT), answer("explained", SOFT), True, True),
        (truth("clutter", SOFT), answer("explained", SOFT, HEAVY), False, False),
        (truth("single", SOFT), NO_ANSWER, False, False),
        (truth("none"), NO_ANSWER, False, False),
    ],
)
def test_what_is_right(sealed: dict, told: dict, right: bool, placed: bool) -> None:
    found = judge_case("a", sealed, told)
    assert (found.right, found.placed) == (right, placed)
    assert bool(found.reason) == (not (right and placed))


@pytest.mark.parametrize(
    ("sealed", "told", "right"),
    [
        (truth("single", SOFT), answer("partial", SOFT, TILT), True),
        (truth("single", SOFT), answer("partial", SOFT, HEAVY), False),
        (truth("single", SOFT), answer("partial", TILT), False),
        (truth("none"), answer("consistent"), True),
        (truth("none"), answer("unexplained"), True),
        (truth("none"), answer("partial", TILT), True),
        (truth("none"), answer("explained", HEAVY), False),
        (truth("none"), NO_ANSWER, False),
        (truth("withheld", SOFT), answer("partial", TILT), True),
        (truth("withheld", SOFT), answer("partial", TILT, HEAVY), False),
        (truth("withheld", SOFT), answer("consistent"), False),
    ],
)
def test_small_effects_of_every_machine_are_neither_asked_for_nor_wrong(sealed: dict, told: dict, right: bool) -> None:
    small = {**effect("imu_bias", {"link": 2}), "alike": [TILT]}
    assert judge_case("a", {**sealed, "clutter": [small]}, told).right == right
    found = judge_case("a", {**sealed, "clutter": [TILT]}, told)
    assert found.right == right and bool(found.reason) == (not right)
    assert found.named == sum(e["id"] != "base_tilt" for e in told["effects"])


def test_a_true_effect_that_a_small_one_is_like_counts_as_named() -> None:
    small = {**effect("imu_bias", {"link": 2}), "alike": [SOFT]}
    found = judge_case("a", {**truth("single", SOFT), "clutter": [small]}, answer("explained", SOFT))
    assert found.right and found.placed and (found.named, found.hits) == (1, 1)


def test_reasons_name_what_happened() -> None:
    assert (
        "wrong place: link_stiffness link 4"
        in judge_case("a", truth("single", SOFT), answer("explained", STIFF)).reason
    )
    assert "not seen" in judge_case("a", truth("withheld", HEAVY), answer("consistent")).reason
    tied = judge_case("a", truth("single", SOFT), answer("ambiguous", HEAVY, ties=("link_stiffness",)))
    assert "in the tie" in tied.reason and tied.held and tied.tied


def test_twins_are_looked_up_from_both_sides() -> None:
    assert "end_hose" in twins("tip_payload") and "tip_payload" in twins("end_hose")
    assert twins("camera_scale") == {"camera_pose"}
    assert "tip_payload" not in twins("camera_scale")


def test_an_interval_may_be_open_and_an_angle_may_turn() -> None:
    interval = {"value": 3.0, "low": 2.0, "high": None}
    assert errors_of({"stiffness": 1e9}, {"stiffness": interval}) == [0]
    assert errors_of({"stiffness": 1.0}, {"stiffness": interval}) == [-2]
    turned = {"value": 6.2, "low": 6.1, "high": 6.4}
    assert errors_of({"phase": -0.05}, {"phase": turned}) == pytest.approx([(2 * np.pi - 6.25) / 0.2])
    assert errors_of({"mass": -0.05}, {"mass": turned}) == pytest.approx([-62.5])
    assert errors_of({"mass": 2.0}, {"mass": {"value": 1.0, "low": 1.0, "high": 1.0}}) == [np.inf]


def test_wilson_meets_the_textbook() -> None:
    assert wilson(108, 120) == pytest.approx((0.833, 0.942), abs=1e-3)
    assert wilson(0, 60) == pytest.approx((0.0, 0.060), abs=1e-3)
    assert wilson(0, 0) == (0.0, 1.0)


def outcomes() -> list[Outcome]:
    rows = [(truth("single", HEAVY), answer("explained", HEAVY, closure=c)) for c in np.linspace(0.9, 0.99, 19)]
    rows += [(truth("single", HEAVY), answer("explained", TILT, closure=0.1))]
    rows += [(truth("none"), answer("consistent"))] * 9 + [(truth("none"), answer("explained", TILT))]
    return [judge_case(str(k), *row) for k, row in enumerate(rows)]


def test_intervals_of_other_levels_are_scaled() -> None:
    one = outcomes()[0]
    many = [replace(one, errors=(float(z) / 1.96,)) for z in np.random.default_rng(1).normal(size=4000)]
    for level in (0.5, 0.8, 0.95):
        assert np.mean(held(many, level)) == pytest.approx(level, abs=0.03)
    assert not any(held([replace(one, errors=(1.01, -1.01))], 0.95))


def test_campaigns_are_pooled_and_told_apart(campaign: tuple[Path, Path, Path]) -> None:
    one = score(*campaign)
    both = pooled([one, replace(one, outcomes=one.outcomes[:1], figures=tuple(figures(one.outcomes[:1])))])
    assert len(both.outcomes) == 4 and both.figures[0].count == 2 and both.seals == one.seals * 2
    assert "| seed 2 |" in markdown_page(both, "picture.svg", "diagram.svg")
    json.dumps(both.document(), allow_nan=False)


def test_figures_count_what_they_say() -> None:
    found = {figure.name: figure for figure in figures(outcomes())}
    assert found["single effect: right id"].value == 0.95 and found["single effect: right id"].met
    assert found["false alarm without effect"].value == 0.1 and found["false alarm without effect"].met is False
    assert found["held-out closure of solved cases, median"].value == pytest.approx(0.945)  # the miss is left out
    assert found["95 % intervals that hold the truth"].count == 19
    assert found["two effects: both named"].met is None


@pytest.fixture
def campaign(tmp_path: Path) -> tuple[Path, Path, Path]:
    folder, seal, answers = tmp_path / "cases", tmp_path / "seal.json", tmp_path / "answers"
    cases = {"aa": truth("single", HEAVY), "bb": truth("withheld", TILT), "cc": truth("none")}
    seal.write_text(json.dumps({"salt": "x", "seed_sha256": "y", "cases": cases}))
    folder.mkdir()
    answers.mkdir()
    (folder / "seal.sha256").write_text(sha256(seal.read_bytes()).hexdigest() + "\n")
    (answers / "aa.json").write_text(json.dumps(answer("explained", HEAVY)))
    (answers / "bb.json").write_text(json.dumps({**answer("unexplained"), "unexplained": {"where": "link 2 <&>"}}))
    return folder, seal, answers


def test_a_missing_answer_is_a_miss(campaign: tuple[Path, Path, Path]) -> None:
    found = score(*campaign)
    assert [o.right for o in found.outcomes] == [True, True, False]
    assert found.outcomes[2].reason == "there is no answer"
    json.dumps(found.document(), allow_nan=False)


def test_an_answer_that_is_none_stops_the_score(campaign: tuple[Path, Path, Path]) -> None:
    *_, answers = campaign
    (answers / "cc.json").write_text('{"verdict": "fine", "effects": []}')
    with pytest.raises(InputError, match=r"cc.json is no answer to its case: verdict: 'fine' is wrong: Input should"):
        score(*campaign)
    (answers / "cc.json").rename(answers / "dd.json")
    with pytest.raises(InputError, match=r"dd.json answers no case; answers are called CASE.json, such as aa.json"):
        score(*campaign)


def test_another_seal_is_refused(campaign: tuple[Path, Path, Path]) -> None:
    folder, seal, answers = campaign
    seal.write_text(seal.read_text().replace("40.0", "41.0"))
    with pytest.raises(InputError, match="published"):
        score(folder, seal, answers)


def test_pages_tell_all(campaign: tuple[Path, Path, Path]) -> None:
    found = score(*campaign)
    markdown, html = markdown_page(found, "picture.svg", "diagram.svg"), html_page(found)
    for page in (markdown, html):
        assert "there is no answer" in page and found.seals[0] in page and "tip_payload" in page
    assert "| tip_payload | 1 | 1 | 1 | 0.96 | 1 of 1 | 50 |" in markdown
    assert (
        "](picture.svg)" in markdown
        and "](diagram.svg)" in markdown
        and "link 2 &lt;&amp;&gt;" in html
        and "<svg" in html
    )
    assert confusion_svg(found.outcomes).count("fill-opacity") == len(found.outcomes)
