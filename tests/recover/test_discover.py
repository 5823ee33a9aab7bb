"""A law that no library has comes back as its formula: cogging of a drive, from a table and a channel map."""

import json
import re
from pathlib import Path

import numpy as np
import pytest

from boom_mj import cli
from boom_mj.cli.documents import GapDiagnose, GapDiscover

MODEL = """
<mujoco model="carriage">
  <option timestep="0.002" integrator="implicitfast" gravity="0 0 0"/>
  <worldbody>
    <body name="carriage">
      <joint name="slide" type="slide" axis="1 0 0"/>
      <geom type="box" size="0.1 0.1 0.1" mass="50"/>
    </body>
  </worldbody>
  <actuator><motor name="motor" joint="slide"/></actuator>
</mujoco>
"""
MAP = """
name = "carriage"
model = "model.xml"
time = "time"
window = 4.0
cutoff = 20.0
settle = 0.5
[[channel]]
name = "position"
role = "drive"
joint = "slide"
field = "position"
unit = "m"
noise = 1e-6
[[channel]]
name = "force"
role = "compare"
actuator = "motor"
field = "force"
unit = "N"
"""
WARM = """
[[channel]]
name = "gearbox"
role = "temperature"
joint = "slide"
field = "gearbox"
unit = "degC"
"""
AMPLITUDE, PERIOD = 12.0, 0.11
GREASE, THINNING = 40.0, 0.8  # N s/m at 35 degC, and how much less per K

pytestmark = pytest.mark.usefixtures("own_files")


def measured(folder: Path, cogging: float, warm: bool = False) -> list[str]:
    """A log, and the words of the command line that come with it; of a carriage whose grease thins as it warms."""
    rng, time = np.random.default_rng(0), np.arange(0.0, 24.0, 0.002)
    rate = 2 * np.pi * np.array([0.21, 0.53])
    size = np.array([0.25, 0.08])
    position = np.sin(np.outer(time, rate)) @ size
    force = -50 * np.sin(np.outer(time, rate)) @ (size * rate**2)
    force += cogging * np.sin(2 * np.pi * position / PERIOD + 0.4) + 0.5 * rng.standard_normal(len(time))
    gearbox = np.round(35 + 8 * np.sin(0.9 * time + 1) + 0.3 * time)
    if warm:
        force += (GREASE - THINNING * (gearbox - 35)) * (np.cos(np.outer(time, rate)) @ (size * rate))
    rows = np.column_stack([time, position + 1e-6 * rng.standard_normal(len(time)), force, gearbox])
    np.savetxt(folder / "log.csv", rows, delimiter=",", header="time,position,force,gearbox", comments="", fmt="%.8f")
    (folder / "model.xml").write_text(MODEL)
    (folder / "map.toml").write_text(MAP + WARM * warm)
    return ["gap", "discover", str(folder / "log.csv"), "--map", str(folder / "map.toml")]


def run(words: list[str], capsys: pytest.CaptureFixture[str]) -> str:
    assert cli.run(words) == 0
    return capsys.readouterr().out


def test_cogging_comes_back_as_a_ripple(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words, law = measured(tmp_path, AMPLITUDE), tmp_path / "cogging.py"
    out = run([*words, "--json", "-", "-o", str(law), "--html", str(tmp_path / "page.html")], capsys)
    found = json.loads(out)
    GapDiscover.model_validate_json(out)
    assert found["verdict"] == "law" and found["law"]["terms"] == ["ripple"], found["sentence"]
    assert found["law"]["place"] == {"joint": "slide"} and found["law"]["same_as"] is None
    size = {name: p["value"] for name, p in found["law"]["parameters"].items()}
    assert size["period"] == pytest.approx(PERIOD, rel=0.01)
    assert np.hypot(size["sine"], size["cosine"]) == pytest.approx(AMPLITUDE, rel=0.05)
    assert found["gap"]["closure"] > 0.95
    assert max(map(len, law.read_text().splitlines())) <= 120
    assert re.search(r"sin\(2 \* pi \* \(position [-+] ", (tmp_path / "page.html").read_text())
    again = json.loads(run(["gap", "diagnose", *words[2:], "--effects", str(law), "--json", "-"], capsys))
    GapDiagnose.model_validate(again)
    assert [effect["id"] for effect in again["effects"]] == ["cogging"], again["sentence"]


def test_grease_that_thins_as_it_warms_comes_back_as_a_law_of_temperature(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words, law = measured(tmp_path, 0.0, warm=True), tmp_path / "grease.py"
    found = json.loads(run([*words, "--json", "-", "-o", str(law), "--html", str(tmp_path / "page.html")], capsys))
    assert found["verdict"] == "law" and found["law"]["place"] == {"joint": "slide"}, found["sentence"]
    assert set(found["law"]["terms"]) == {"viscous", "warm_viscous"}
    size = {name: p["value"] for name, p in found["law"]["parameters"].items()}
    assert size["warm_viscous"] == pytest.approx(-THINNING, rel=0.1)
    middle = float(re.search(r"temperature - ([\d.]+)", found["law"]["formula"])[1])  # type: ignore[index]
    assert size["viscous"] == pytest.approx(GREASE - THINNING * (middle - 35), rel=0.05)
    assert found["gap"]["closure"] > 0.95
    again = json.loads(run(["gap", "diagnose", *words[2:], "--effects", str(law), "--json", "-"], capsys))
    assert [effect["id"] for effect in again["effects"]] == ["grease"], again["sentence"]


def test_mass_that_the_model_lacks_comes_back_as_inertia(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = measured(tmp_path, 0.0)
    (tmp_path / "model.xml").write_text(MODEL.replace('mass="50"', 'mass="38"'))
    found = json.loads(run([*words, "--without", "armature", "--json", "-"], capsys))
    assert found["law"]["formula"] == "inertia * rate(time, speed)", found["sentence"]
    assert found["law"]["parameters"]["inertia"]["value"] == pytest.approx(12.0, rel=0.01)


def test_without_time_it_says_so(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    found = json.loads(run([*measured(tmp_path, AMPLITUDE), "--time", "0", "--json", "-"], capsys))
    assert found["verdict"] == "none" and found["skipped"] and not found["complete"]
    assert "no time to fit a law" in found["sentence"]


def test_noise_alone_is_nothing_to_discover(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    found = json.loads(run([*measured(tmp_path, 0.0), "--json", "-"], capsys))
    assert found["verdict"] == "none" and found["law"] is None and "nothing to discover" in found["sentence"]
