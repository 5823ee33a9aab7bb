"""The commands as a user runs them: results on stdout, one sentence on stderr, nothing half-written."""

import json
import subprocess
import sys
from pathlib import Path

import mujoco
import pytest

from boom_mj import cli
from boom_mj.cli.arguments import begins_afresh
from boom_mj.logs import read_mcap, write_mcap
from boom_mj.recording import Recording

ROOT = Path(__file__).parents[2]
MACHINE, LOG = ROOT / "models" / "boom36.toml", ROOT / "logs" / "independent_release_stretched_vertical.mcap"


def boom(*arguments: object) -> subprocess.CompletedProcess:
    command = [sys.executable, "-m", "boom_mj", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, cwd=ROOT, timeout=300)


def test_generate_simulate_replay(tmp_path: Path) -> None:
    made = boom("generate", MACHINE, "-o", tmp_path / "boom.xml", "--hinges", 2)
    assert made.returncode == 0, made.stderr
    assert mujoco.MjModel.from_xml_path(str(tmp_path / "boom.xml")).nv == 5 + 4 * 3 * 2

    simulated = boom("simulate", MACHINE, "slew_t", "-o", tmp_path / "slew.mcap")
    assert simulated.returncode == 0, simulated.stderr
    again = boom("simulate", MACHINE, "slew_t", "-o", tmp_path / "again.mcap")
    assert again.returncode == 0
    assert (tmp_path / "slew.mcap").read_bytes() == (tmp_path / "again.mcap").read_bytes()

    replayed = boom(
        "replay", tmp_path / "slew.mcap", "-o", tmp_path / "twin.mcap", "--picture", tmp_path / "p.png", "--json"
    )
    assert replayed.returncode == 0, replayed.stderr
    document = json.loads(replayed.stdout)
    assert set(document["timing"]) == {"simulated_s", "steps", "loop_wall_s"}
    # the same model on both sides: what is left is sensor noise and what it does to the joint angles
    assert all(group["ratio"] < 2 for group in document["groups"].values())
    assert "markers" in read_mcap(tmp_path / "twin.mcap")
    assert (tmp_path / "p.png").read_bytes().startswith(b"\x89PNG")


def test_validate_gives_one_document() -> None:
    done = boom("validate", MACHINE, "--poses", 3, "--json")
    assert done.returncode == 0, done.stderr
    figures = json.loads(done.stdout)["hinges"]["1"]
    assert {"sag", "load_change", "mode1", "mode4", "finite_rotations", "mass_matrix_worst"} <= set(figures)


@pytest.mark.parametrize(
    ("arguments", "status", "told"),
    [
        (["simulate", MACHINE, "jump"], 2, "slew_t"),
        (["simulate", "nowhere.toml", "slew_t"], 2, "nowhere.toml"),
        (["simulate", MACHINE, "slew_t", "--effect", "gremlins:size=1"], 2, "gremlins"),
        (["simulate", MACHINE, "slew_t", "-o", "no_folder/out.mcap"], 2, "no_folder"),
        (["simulate", MACHINE, "slew_t", "-o", "out.txt"], 2, ".mcap"),
        (["generate", MACHINE, "--hinges", "0"], 2, "hinges"),
        (["replay", "nowhere.mcap"], 2, "nowhere.mcap"),
        (["replay", MACHINE], 1, "not an MCAP file"),
        (["calibrate", MACHINE], 2, "LOGS"),
        (["calibrate", MACHINE, "nowhere.mcap"], 2, "nowhere.mcap"),
        (["calibrate", "nowhere.toml", LOG], 2, "nowhere.toml"),
        (["calibrate", MACHINE, LOG, "--free", "colour"], 2, "shear_modulus"),
        (["calibrate", MACHINE, LOG, "-o", "out.txt"], 2, ".toml"),
        (["calibrate", MACHINE, LOG, "--html", "no_folder/page.html"], 2, "no_folder"),
        (["calibrate", MACHINE, MACHINE], 1, "not an MCAP file"),
        (["fly"], 2, "fly"),
    ],
)
def test_wrong_calls(arguments: list, status: int, told: str) -> None:
    done = boom(*arguments)
    assert done.returncode == status
    assert told in done.stderr
    assert "Traceback" not in done.stderr
    assert done.stdout == ""


def test_logs_that_cannot_be_replayed(tmp_path: Path) -> None:
    half, empty = tmp_path / "half.mcap", tmp_path / "empty.mcap"
    half.write_bytes(LOG.read_bytes()[:2000])
    log = read_mcap(LOG)
    others = {name: signal for name, signal in log.signals.items() if name != "joint/position"}
    write_mcap(Recording(log.name, log.machine, log.description, others), empty)
    for path, told in ((half, "cut off"), (empty, "joint/position")):
        done = boom("replay", path, "-o", tmp_path / "twin.mcap")
        assert done.returncode == 1
        assert told in done.stderr and "Traceback" not in done.stderr
        assert not (tmp_path / "twin.mcap").exists()
    assert sorted(p.name for p in tmp_path.iterdir()) == ["empty.mcap", "half.mcap"]


def test_the_version_names_what_computes() -> None:
    said = boom("--version")
    assert said.returncode == 0
    assert said.stdout.startswith("boom_mj ") and f"MuJoCo {mujoco.__version__}" in said.stdout


@pytest.mark.parametrize("place", [0, 2])
def test_quiet_leaves_results_and_errors(tmp_path: Path, place: int) -> None:
    def quiet(*words: object) -> subprocess.CompletedProcess:
        return boom(*words[:place], "--quiet", *words[place:])

    model = quiet("generate", "boom36", "-o", tmp_path / "boom.xml")
    assert (model.stdout, model.stderr) == (f"{tmp_path / 'boom.xml'}\n", "")
    loud, hushed = boom("replay", LOG), quiet("replay", LOG)
    assert (loud.stdout, hushed.stderr) == (hushed.stdout, "") and loud.stderr
    missing, wrong = quiet("replay", tmp_path / "no.mcap"), quiet("replay", LOG, "--wrong")
    assert (missing.returncode, wrong.returncode) == (2, 2)
    assert "there is no such log" in missing.stderr and "--wrong" in wrong.stderr


def test_completion_is_there_for_the_shell(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("_TYPER_COMPLETE_TEST_DISABLE_SHELL_DETECTION", "1")  # there may be none around the tests
    script = boom("--show-completion", "bash")
    assert script.returncode == 0 and "COMPLETE" in script.stdout


@pytest.mark.parametrize(
    "error",
    [
        MemoryError(),
        OSError(12, "Cannot allocate memory"),
        mujoco.FatalError("Could not allocate memory"),
        RuntimeError("can't start new thread"),
        ImportError("x.so: failed to map segment from shared object"),
    ],
)
def test_a_memory_that_ends_is_a_sentence_whatever_came_upon_it(
    error: Exception, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def full(words: object) -> None:
        raise error

    monkeypatch.setattr(cli, "app", full)
    assert cli.run(["generate"]) == 1
    assert capsys.readouterr().err == "error: there is not enough memory for this\n"
    monkeypatch.setattr(cli, "app", lambda words: (_ for _ in ()).throw(RuntimeError("another")))
    with pytest.raises(RuntimeError, match="another"):
        cli.run(["generate"])


def test_work_that_begins_afresh_says_what_a_stopped_call_left(tmp_path: Path) -> None:
    table = tmp_path / "out.json"
    assert begins_afresh(None) == begins_afresh(table) == "begins afresh"
    for text, told in (('{"complete": false}', True), ('{"complete": true}', False), ("[1]", False), ("{", False)):
        table.write_text(text)
        assert ("stopped" in begins_afresh(table)) == told


@pytest.mark.parametrize("stopped", [False, True])
def test_what_a_binding_makes_of_an_interrupt_is_one(
    stopped: bool, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture
) -> None:
    """Ctrl-C while C++ converts an argument ends in a TypeError about that argument."""

    def binding(words: list[str]) -> None:
        try:
            if stopped:
                cli._stop(2, None)
        except KeyboardInterrupt:
            pass
        raise TypeError("incompatible function arguments")

    monkeypatch.setattr(cli, "app", binding)
    monkeypatch.setattr(cli, "_stops", [])
    if stopped:
        assert cli.run(["simulate"]) == 1 and capsys.readouterr().err == "error: interrupted\n"
    else:
        with pytest.raises(TypeError):
            cli.run(["simulate"])
