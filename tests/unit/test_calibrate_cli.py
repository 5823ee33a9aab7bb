"""calibrate as a user runs it: files it writes, one sentence on stderr where it cannot."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from boom_mj.calibration.answer import replaced_text
from boom_mj.errors import MachineFileError
from boom_mj.logs import read_mcap, write_mcap
from boom_mj.machine import load_machine
from boom_mj.recording import Recording
from boom_mj.sensors import record
from boom_mj.simulation import CATALOGUE, make_plant, run_experiment

ROOT = Path(__file__).parents[2]
MACHINE, LOG = ROOT / "models" / "boom36.toml", ROOT / "logs" / "independent_release_stretched_vertical.mcap"


def boom(*arguments: object) -> subprocess.CompletedProcess:
    command = [sys.executable, "-m", "boom_mj", "calibrate", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, cwd=ROOT, timeout=300)


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Ten seconds of a machine with half as much damping again."""
    plan = CATALOGUE["release_bow_vertical"].model_copy(update={"duration": 10.0, "release": 2.0})
    machine = load_machine(MACHINE)
    damping = machine.damping.model_copy(update={"relaxation_time": 1.5 * machine.damping.relaxation_time})
    motion = run_experiment(make_plant(machine.model_copy(update={"damping": damping}), 4), plan)
    path = tmp_path_factory.mktemp("logs") / "release.mcap"
    write_mcap(record(motion, plan, np.random.default_rng(0)), path)
    return path


def test_files_that_it_writes(log: Path, tmp_path: Path) -> None:
    toml, answer, page = (tmp_path / f"out.{suffix}" for suffix in ("toml", "json", "html"))
    done = boom(MACHINE, log, "--free", "damping", "-o", toml, "--json", answer, "--html", page)
    assert done.returncode == 0, done.stderr
    assert "calibrated" in done.stdout
    assert load_machine(toml).damping.relaxation_time == pytest.approx(1.5 * 0.0127, rel=0.02)
    (parameter,) = json.loads(answer.read_text())["parameters"]
    assert parameter["name"] == "damping" and parameter["low"] < 1.5 * 0.0127 < parameter["high"]
    text = page.read_text()
    assert "release_bow_vertical" in text
    assert not [
        word for word in ("http://", "https://", "<script", "<link") if word in text.replace("http://www.w3.org", "")
    ]


def test_a_log_that_tells_nothing(tmp_path: Path) -> None:
    whole = read_mcap(LOG)
    bare = tmp_path / "bare.mcap"
    write_mcap(Recording(whole.name, whole.machine, "", {"joint/position": whole["joint/position"]}), bare)
    done = boom(MACHINE, bare, "-o", tmp_path / "out.toml")
    assert done.returncode == 1
    assert whole.name in done.stderr and "nothing to compare" in done.stderr and "Traceback" not in done.stderr
    assert not (tmp_path / "out.toml").exists()


def test_values_that_cannot_be_replaced() -> None:
    text = MACHINE.read_text()
    inline = text[: text.index("[damping]")] + text[text.index("[point_masses]") :]
    inline = inline.replace(
        "[slewing]", "damping = { relaxation_time = 0.0127, bending = 0.0, torsion = 0.0 }\n[slewing]"
    )
    place = {("damping", 0, "relaxation_time"): 0.02}
    assert "relaxation_time = 0.02 " in replaced_text(text, place)
    with pytest.raises(MachineFileError, match=r"damping\.relaxation_time .* line of its own|of its own"):
        replaced_text(inline, place)
