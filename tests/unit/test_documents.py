"""The documents of --json: valid JSON, with the keys that the schema promises, for every command."""

import json
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
import typer
from mcap.reader import make_reader
from opengl import can_render

import boom_mj.blind
from boom_mj.blind.figures import Score, figures
from boom_mj.blind.grading import Outcome
from boom_mj.cli import app, run
from boom_mj.cli.documents import DOCUMENTS, Part
from boom_mj.cli.schema import schema

NO_DOCUMENT = {"schema"}  # it prints one itself
DROP = """
name = "drop"
pose_deg = [0, 60, -35, -40, -45]
duration = 6
load = [0, 0, -490.5]
release = 1.5
"""
needs_egl = pytest.mark.skipif(not can_render(), reason="EGL cannot render here")
Ask = Callable[..., dict[str, Any]]


def leaves(group: Any, name: str = "") -> Iterator[tuple[str, Any]]:
    for key, command in getattr(group, "commands", {}).items():
        full = f"{name} {key}".strip()
        if hasattr(command, "commands"):
            yield from leaves(command, full)
        else:
            yield full, command


COMMANDS = dict(leaves(typer.main.get_command(app)))


def refuse(word: str) -> None:
    raise AssertionError(f"{word} is no JSON")


@pytest.fixture
def ask(capsys: pytest.CaptureFixture) -> Ask:
    """Call a command and hold its document against the schema."""

    def asked(command: str, *words: object, kind: int = 0, status: int = 0, file: Path | None = None) -> dict[str, Any]:
        capsys.readouterr()
        assert run([*command.split(), *map(str, words)]) == status
        text = capsys.readouterr().out if file is None else file.read_text()
        found = json.loads(text, parse_constant=refuse)
        DOCUMENTS[command][kind].model_validate_json(text)
        return found

    return asked


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("documents") / "log.mcap"
    assert run(["simulate", "boom36", "release_bow_vertical", "-o", str(path), "--effect", "tip_payload:mass=40"]) == 0
    return path


def test_every_command_has_a_document() -> None:
    assert set(COMMANDS) - NO_DOCUMENT == set(DOCUMENTS)
    for name in DOCUMENTS:
        assert "--json" in {option for parameter in COMMANDS[name].params for option in parameter.opts}, name


def test_the_schema_holds_every_document(ask: Ask, capsys: pytest.CaptureFixture) -> None:
    assert run(["schema"]) == 0
    whole = json.loads(capsys.readouterr().out)
    assert whole == schema() and set(whole["commands"]) == set(DOCUMENTS)
    for kinds in whole["commands"].values():
        assert all(kind["$ref"].removeprefix("#/$defs/") in whole["$defs"] for kind in kinds)
    diagnosis = whole["$defs"]["GapDiagnose"]
    assert {"verdict", "sentence", "effects", "rivals", "ties", "gap", "where"} <= set(diagnosis["required"])
    assert diagnosis["additionalProperties"] is True
    assert run(["schema", "nothing"]) == 2 and "gap diagnose" in capsys.readouterr().err


def test_a_key_that_is_missing_or_of_another_kind_is_found() -> None:
    class Told(Part):
        number: float

    Told.model_validate_json('{"number": 1, "more": true}')
    for wrong in ("{}", '{"number": "1"}', '{"number": null}'):
        with pytest.raises(ValueError):
            Told.model_validate_json(wrong)


def test_generate(ask: Ask, tmp_path: Path, capsys: pytest.CaptureFixture) -> None:
    model = ask("generate", "boom36", "-o", tmp_path / "b.xml", "--json", "--hinges", 2)
    assert model["degrees_of_freedom"] == 29 and "bow" in model["keyframes"] and "tip_position" in model["sensors"]
    assert ask("generate", "boom36", "-o", tmp_path / "b.urdf", "--urdf", "--json")["format"] == "urdf"
    assert run(["generate", "boom36", "--json"]) == 2


def test_simulate(ask: Ask, tmp_path: Path) -> None:
    found = ask("simulate", "boom36", "slew_t", "--json", "-o", tmp_path / "a.mcap")
    assert found["simulated_s"] == 30 and Path(found["recording"]).is_file()
    sweep = ("--sweep", "tip_payload:mass=0..20/2", "-o", tmp_path / "many", "--json")
    assert ask("simulate", "boom36", "slew_t", *sweep, kind=1)["recorded"] == 2


def test_replay_and_inspect(ask: Ask, log: Path) -> None:
    groups = ask("replay", log, "--json")["groups"]
    assert max(groups, key=lambda name: groups[name]["ratio"]).startswith(("markers", "cylinder", "imu"))
    assert {topic["topic"] for topic in ask("logs inspect", log, "--json")["topics"]} >= {"/joint_states", "/markers"}


def test_validate(ask: Ask) -> None:
    assert ask("validate", "boom36", "--poses", 2, "--json")["poses"] == 2


@pytest.mark.slow
def test_calibrate(ask: Ask, tmp_path: Path) -> None:
    drop, log = tmp_path / "drop.toml", tmp_path / "drop.mcap"
    drop.write_text(DROP)
    ask("simulate", "boom36", drop, "-o", log, "--json")
    words = ("boom36", log, "--free", "damping", "--json", tmp_path / "c.json")
    ask("calibrate", *words, file=tmp_path / "c.json")
    ask("calibrate", *words, "--plan", kind=1, file=tmp_path / "c.json")


@pytest.mark.slow
def test_gap_diagnose(ask: Ask, tmp_path: Path) -> None:
    taught, unseen, file = tmp_path / "taught.mcap", tmp_path / "unseen.mcap", tmp_path / "a.json"
    fault = ("--hinges", 4, "--effect", "pressure_scale:cylinder=3,factor=1.05", "--json")
    ask("simulate", "boom36", "release_bow_vertical", "-o", taught, *fault)
    ask("simulate", "boom36", "slew_t", "-o", unseen, "--seed", 1, *fault)  # what has the same noise is a copy
    words = (taught, "--holdout", unseen, "--predictions", tmp_path / "twins", "--json", file)
    answer = ask("gap diagnose", *words, file=file)
    assert answer["verdict"] == "explained" and answer["effects"][0]["id"] == "pressure_scale"
    with (tmp_path / "twins" / "unseen.nominal.mcap").open("rb") as stream:
        summary = make_reader(stream).get_summary()
    assert summary is not None
    topics = {channel.topic for channel in summary.channels.values()}
    assert {"/markers", "/measured/markers", "/residual/markers", "/residual/cylinder_states"} <= topics


def test_gap_effects(ask: Ask) -> None:
    found = ask("gap effects", "--json")
    (payload,) = (effect for effect in found["effects"] if effect["id"] == "tip_payload")
    assert payload["parameters"]["mass"]["unit"] == "kg" and payload["locations"] == [{}]
    assert all(row["reason"] and row["unit"] for row in ask("gap criteria", "--json")["criteria"])


def test_blind(ask: Ask, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def make_cases(count: int, *given: Any) -> Iterator[int]:
        (tmp_path / "cases").mkdir()
        (tmp_path / "cases" / "seal.sha256").write_text("0" * 64)
        yield from range(1, count + 1)

    monkeypatch.setattr(boom_mj.blind, "make_cases", make_cases)
    (tmp_path / "secret").write_bytes(bytes(32))
    words = ("--cases", 2, "--seed-file", tmp_path / "secret", "-o", tmp_path / "cases", "--seal", tmp_path / "seal")
    assert ask("gap blind make", *words, "--json")["cases"] == 2
    monkeypatch.setattr(boom_mj.blind, "waiting_cases", lambda folder, answers: ([], 2))
    (tmp_path / "cases" / "machine.toml").write_text("")
    assert ask("gap blind run", tmp_path / "cases", "--json")["cases"] == 2
    outcome = Outcome(
        "0", "single", "wind", "wind", True, True, False, True, (0.5,), 0.9, 3.0, 60.0, "", "", "", float("nan")
    )
    score = Score((outcome,), tuple(figures((outcome,))), ("a" * 64,), ("b" * 64,), ())
    monkeypatch.setattr(boom_mj.blind, "score", lambda *given: score)
    file = tmp_path / "score.json"
    ask(
        "gap blind score",
        tmp_path / "cases",
        "--seal",
        tmp_path / "seal",
        "--json",
        file,
        "--method",
        "ours",
        file=file,
    )


@needs_egl
def test_pictures(ask: Ask, log: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MUJOCO_GL", "egl")
    film = ask("view", log, "--record", tmp_path / "film.webm", "--speed", 100, "--json")
    assert film["pictures"] == 8
    words = ("--start", 8, "--stop", 8.1, "--scale", 0.1, "--no-calibration", "--camera", "camera1", "--json")
    found = ask("render", log, "-o", tmp_path / "set", *words)
    assert found["cameras"] == ["camera1"] and found["frames"] == len(
        list((tmp_path / "set" / "images").rglob("*.png"))
    )
