"""An experiment is designed by what it would tell: the criterion by other means, motions within limits, the command."""

import json
import sys
from pathlib import Path

import numpy as np
import pytest

from boom_mj import cli
from boom_mj.cli.documents import DOCUMENTS
from boom_mj.effects import parse_effect
from boom_mj.machine import load_machine
from boom_mj.simulation import CATALOGUE, Experiment
from boom_mj.simulation.experiments import Move, parse_experiment
from boom_mj.systems.boom import design
from boom_mj.systems.boom.design import Explanation, Judge, Outlook, designed
from boom_mj.systems.boom.motions import as_toml, drawn, fits, varied

MACHINE = load_machine("boom36")
STILL = Experiment(name="still", pose_deg=(0, 45, -20, -20, -20), duration=10)
MOVING = STILL.model_copy(
    update={"name": "moving", "move": (Move(joint=2, start=2, angle_deg=8, speed_deg_s=2), *STILL.move)}
)


def explanation(*texts: str) -> Explanation:
    return Explanation.of(tuple(map(parse_effect, texts)))


def test_what_is_left_is_a_least_squares_problem_with_priors() -> None:
    rng = np.random.default_rng(0)
    difference, columns = rng.normal(size=50), rng.normal(size=(50, 4))
    rows = np.vstack([columns, np.eye(4)])
    wanted = np.concatenate([difference, np.zeros(4)])
    least = np.sum((wanted - rows @ np.linalg.lstsq(rows, wanted)[0]) ** 2)
    assert design._left(difference, columns) == pytest.approx(least)


@pytest.mark.parametrize("separation", [0.0, 0.7, 2.0, 4.0])
def test_probability_of_the_right_one_is_that_of_drawn_data(separation: float) -> None:
    """Data of one explanation, of deviation 1 about it: by Bayes' rule, drawn a hundred thousand times."""
    data = np.random.default_rng(1).normal(size=100_000)
    likelihood = np.exp(-(data**2) / 2), np.exp(-((data - separation) ** 2) / 2)
    drawn_mean = np.mean(likelihood[0] / (likelihood[0] + likelihood[1]))
    assert Outlook(separation, (), 0.0).probability == pytest.approx(drawn_mean, abs=0.005)


def test_an_explanation_is_not_told_from_itself() -> None:
    same = explanation("tip_payload:mass=40")
    assert Judge(MACHINE, [same, same]).outlook(STILL).separation == pytest.approx(0.0, abs=1e-6)


def test_friction_is_seen_where_something_moves() -> None:
    judge = Judge(MACHINE, [explanation("viscous_friction:joint=2,factor=1.5")])
    still, moving = (judge.outlook(plan).left[0] for plan in (STILL, MOVING))
    assert still == pytest.approx(1.0, abs=1e-3) and moving < 0.1


def test_sizes_are_known_as_well_as_their_spread_over_drawn_noise_says() -> None:
    """Estimates from noisy data, nuisances among them, scatter as the outlook has it: a payload seen at rest."""
    own, rng = explanation("tip_payload:mass=40"), np.random.default_rng(2)
    judge = Judge(MACHINE, [own])
    (effects, by), nominal = own.moved(0), judge._said((), STILL)
    slope = (judge._said(effects, STILL) - judge._said(own.effects, STILL)) / by
    beside = [(judge._said(n.hypothesis, STILL) - nominal) * n.deviation for n in design.nuisances()]
    columns = np.stack([slope, *beside], axis=1)
    normal = np.eye(columns.shape[1]) + columns.T @ columns
    true = rng.normal(size=(columns.shape[1], 400))
    data = columns @ true + rng.normal(size=(len(slope), 400))
    errors = np.linalg.solve(normal, columns.T @ data)[0] - true[0]
    assert judge.outlook(STILL).left[0] == pytest.approx(np.std(errors), rel=0.12)


@pytest.mark.parametrize("load", [0.0, 500.0])
def test_motions_are_what_the_machine_can_do_and_files_hold_them(load: float, tmp_path: Path) -> None:
    rng, cut = np.random.default_rng(3), 0
    for _ in range(40):
        plan = drawn(MACHINE, 40.0, load, rng)
        if not fits(plan, MACHINE):
            continue
        plan.check(MACHINE)
        cut += plan.release is not None
        (tmp_path / "designed.toml").write_text(as_toml(plan))
        assert parse_experiment(str(tmp_path / "designed.toml")) == plan
        other = varied(plan, MACHINE, rng)
        other.check(MACHINE)
        assert other.duration == plan.duration
    assert bool(cut) == bool(load)


def test_a_design_tells_more_than_the_median_of_what_was_drawn(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(design, "CATALOGUE", {"still": STILL})
    pair = [explanation("tip_payload:mass=40"), explanation("link_mass:link=5,factor=1.3")]
    found = designed(MACHINE, pair, 12.0, tries=2, rng=np.random.default_rng(4))
    assert found.best[1].gain >= found.random[1].gain and found.best[1].gain >= found.catalogue[1].gain
    assert found.catalogue[0].name == "still" and found.best[0].duration <= 12.0


ANSWER = {
    "verdict": "explained",
    "provenance": {"machine": "boom36"},
    "ties": [],
    "effects": [
        {
            "id": "tip_payload",
            "location": {},
            "parameters": {"mass": {"value": 40.0, "low": 30.0, "high": 50.0, "unit": "kg"}},
        }
    ],
}


def called(monkeypatch: pytest.MonkeyPatch, *words: object) -> int:
    monkeypatch.setattr(sys, "argv", ["boom_mj", *map(str, words)])
    return cli.run(list(map(str, words)))


def test_an_answer_becomes_a_file_that_simulate_runs(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "gap.json").write_text(json.dumps(ANSWER))
    words = ["gap", "design", tmp_path / "gap.json", "--seconds", 12, "--tries", 1, "--json", "-"]
    assert called(monkeypatch, *words, "-o", tmp_path / "next.toml") == 0
    document = json.loads(capsys.readouterr().out)
    DOCUMENTS["gap design"][0].model_validate(document)
    assert 0 < document["sizes"][0]["left"] < 1 and document["designed"]["separation"] is None
    assert parse_experiment(str(tmp_path / "next.toml")).pose_deg == tuple(document["experiment"]["pose_deg"])
    assert called(monkeypatch, "simulate", "boom36", tmp_path / "next.toml", "-o", tmp_path / "log.mcap") == 0


@pytest.mark.parametrize(
    ("change", "words", "said"),
    [
        ({"effects": [], "verdict": "consistent"}, ["ANSWER"], "neither ties nor effects"),
        ({"verdict": "so so"}, ["ANSWER"], "is no answer"),
        (
            {"effects": [{"id": "dead_zone", "location": {"actuator": "motor"}}]},
            ["ANSWER"],
            "cannot have the effect dead_zone",
        ),
        ({}, [], "give an answer"),
        ({"provenance": {}}, ["ANSWER"], "of which machine"),
        ({"ties": [[{"id": "tip_payload", "location": {}}]]}, ["ANSWER"], "tip_payload has no sizes"),
        ({}, ["--machine", "boom36", "--between", "tip_load:mass=3"], "tip_load"),
    ],
)
def test_what_cannot_be_designed_for_is_said(
    change: dict, words: list[str], said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "gap.json").write_text(json.dumps({**ANSWER, **change}))
    words = [str(tmp_path / "gap.json") if word == "ANSWER" else word for word in words]
    assert cli.run(["gap", "design", *words]) == 2
    assert said in capsys.readouterr().err


def test_the_next_experiment_of_the_catalogue_is_one_that_was_not_done() -> None:
    pair = [parse_effect(text) for text in ("tip_payload:mass=40", "link_mass:link=5,factor=1.3")]
    done = [name for name, plan in CATALOGUE.items() if plan.duration > 30 or "release" in name]
    chosen = design.next_experiment(MACHINE, [(effect,) for effect in pair], done)
    assert chosen in CATALOGUE and chosen not in done
