"""Answers of any method: what is malformed and why, what their probabilities are, and a method's row of figures."""

import json
from pathlib import Path

import numpy as np
import pytest

from boom_mj.blind import answer_schema, leaderboard, leaderboard_row, read_answer
from boom_mj.blind.answers import Answer
from boom_mj.blind.figures import figures
from boom_mj.blind.grading import judge_case
from boom_mj.blind.pictures import reliability_svg
from boom_mj.blind.probabilities import brier_score, calibration_error, given, log_score, reliability
from boom_mj.blind.task import EXAMPLE, readme
from boom_mj.cli.documents import GapDiagnose

HEAVY = {"id": "tip_payload", "parameters": {"mass": {"value": 40.0, "low": 38, "high": None}}, "probability": 0.8}


@pytest.fixture
def read(tmp_path: Path):
    def written(content: object) -> dict:
        (tmp_path / "aa.json").write_text(content if isinstance(content, str) else json.dumps(content))
        return read_answer(tmp_path / "aa.json")

    return written


def told(**more: object) -> dict:
    return {"verdict": "explained", "effects": [HEAVY], **more}


@pytest.mark.parametrize(
    ("content", "reason"),
    [
        ("{", "aa.json"),
        ([], "aa.json is no answer"),
        ({"verdict": "explained"}, "effects: Field required"),
        (told(verdict="sure"), "verdict: 'sure' is wrong: Input should be 'consistent'"),
        (told(effects=[]), "the verdict is 'explained' but effects names no cause"),
        (told(effects=[{**HEAVY, "id": "gremlin"}]), "there is no effect 'gremlin'; there are actuator_bias"),
        (told(effects=[{**HEAVY, "probability": 80}]), "effects.0.probability: 80 is wrong: .*less than or equal to 1"),
        (told(effects=[{"id": "wind", "parameters": {"mean_speed": 3}}]), "effects.0.parameters.mean_speed: 3 is"),
        (told(effects=[{"id": "wind", "parameters": {"mean_speed": {"value": 3, "low": 2, "high": 1}}}]), "above high"),
        (told(others={"none": 2}, ties=1), "1 more of its values are wrong"),
    ],
)
def test_a_malformed_answer_is_named_with_its_reason(read, content: object, reason: str) -> None:
    from boom_mj.errors import InputError

    with pytest.raises(InputError, match=reason) as caught:
        read(content)
    assert "\n" not in str(caught.value)


def test_what_may_be_left_out_is_filled_in(read) -> None:
    found = read(told())
    assert (found["ties"], found["effects"][0]["location"]) == ((), {})
    outcome = judge_case("a", {"class": "single", "effects": [effect()], "visibility": 3.0}, found)
    assert outcome.placed and outcome.errors == (0.0,) and np.isnan(outcome.wall_s)


def effect(mass: float = 41.0) -> dict:
    return {"id": "tip_payload", "location": {}, "parameters": {"mass": mass}}


def test_the_schema_is_a_part_of_what_a_diagnosis_writes() -> None:
    ours = GapDiagnose.model_json_schema()
    for name in ("verdict", "effects", "others", "ties"):
        assert name in answer_schema()["properties"] and name in ours["properties"]
    assert ours["properties"]["verdict"]["enum"] == answer_schema()["properties"]["verdict"]["enum"]
    assert answer_schema()["required"] == ["verdict", "effects"]
    number, null = answer_schema()["$defs"]["Cause"]["properties"]["probability"]["anyOf"]
    assert (number["minimum"], number["maximum"], null) == (0, 1, {"type": "null"})
    Answer.model_validate(EXAMPLE)
    assert "`link_stiffness` | `link`: 2, 3, 4, 5" in readme() and json.dumps(EXAMPLE, indent=1) in readme()


def test_the_probability_is_that_of_what_is_said(read) -> None:
    assert read(told(probability=1 + 1e-12))["verdict"] == "explained"
    assert given(told()) == 0.8 and given(told(probability=0.3)) == 0.3
    assert given(told(effects=[HEAVY, {**HEAVY, "probability": 0.5}])) == 0.5
    others = {"none": 0.7, "outside_library": 0.2}
    assert given({"verdict": "consistent", "effects": [], "others": others}) == 0.7
    assert given({"verdict": "unexplained", "effects": [], "others": others}) == 0.2
    assert np.isnan(given({"verdict": "consistent", "effects": []}))
    assert np.isnan(given(told(effects=[{**HEAVY, "probability": None}])))


def test_probabilities_are_scored_as_defined() -> None:
    p, y = np.array([0.9, 0.9, 0.6, 0.1, 1.0]), np.array([True, False, True, False, True])
    assert brier_score(p, y) == pytest.approx((0.01 + 0.81 + 0.16 + 0.01 + 0) / 5)
    assert log_score(p, y) == pytest.approx(-np.log([0.9, 0.1, 0.6, 0.9, 0.999]).mean())
    assert [(b.count, b.true) for b in reliability(p, y)] == [(1, 0), (1, 1), (3, pytest.approx(2 / 3))]
    assert calibration_error(p, y) == pytest.approx((0.1 + 0.4 + 3 * abs(2.8 / 3 - 2 / 3)) / 5)
    rng = np.random.default_rng(0)
    sure = rng.random(20000)
    assert calibration_error(sure, rng.random(20000) < sure) < 0.02  # they mean what they say: 0.011 is chance


def graded(kind: str, *answers: dict) -> list:
    sealed = {"class": kind, "effects": [effect(m) for m in (41.0,)], "visibility": 3.0}
    return [judge_case(str(k), sealed, {"gap": {}, "ties": [], "sentence": "", **a}) for k, a in enumerate(answers)]


def test_a_partial_answer_is_true_where_what_it_names_is_there(read) -> None:
    wind = {"id": "wind", "location": {}, "parameters": {}, "probability": 0.4}
    (true,), (false,) = graded("several", read(told(verdict="partial"))), graded("several", read(told(effects=[wind])))
    assert (true.true, true.hits, true.named, true.causes) == (True, 1, 1, 1)
    assert (false.true, false.hits, false.probability) == (False, 0, 0.4)


def test_a_method_has_one_row(read) -> None:
    found = graded("single", read(told(wall_s=3.0)), read(told(effects=[{**HEAVY, "id": "end_hose"}], wall_s=5.0)))
    row = leaderboard_row("ours", figures(found))
    assert row["single: id and place"] == "50 % of 2 (9 % to 91 %)" and row["median s"].startswith("4 (")
    assert {f.name: f.count for f in figures(found)}["held-out closure of solved cases, median"] == 0  # none is given
    assert row["Brier score"].startswith("0.34 (") and row["false alarms"] == "-"
    head, rule, line = leaderboard([row]).splitlines()
    assert head.count("|") == rule.count("|") == line.count("|") and line.startswith("| ours | 50 %")
    assert reliability_svg(found).count("<circle") == 1
