"""What `gap diagnose --map` writes of a pendulum that lacks damping: its page, and recordings as theory has them."""

import subprocess
import sys
from functools import cache
from pathlib import Path
from tempfile import mkdtemp

import numpy as np
import pytest
from test_diagnosis_page import Reader, links

from boom_mj.logs.columns import read_columns

ROOT = Path(__file__).parents[2]
LOG = "a<b>&.csv"
NOISE = 0.01  # N m
DAMPING, INERTIA = 0.5, 1.004  # N m s/rad; kg m^2 of a ball of 1 kg and 0.1 m, 1 m away
MODEL = """<mujoco><option gravity="0 0 0"/><worldbody><body name="arm"><joint name="swing"/>
<geom size="0.1" mass="1" pos="1 0 0"/></body></worldbody>
<actuator><motor name="motor" joint="swing"/></actuator></mujoco>"""
MAP = """
name = "pendulum <b>"
time = "t"
time_scale = 1e-3
model = "one.xml"
window = 5.0
settle = 0.5
channel = [
  {name = "q", role = "drive", joint = "swing", field = "q", unit = "rad"},
  {name = "torque", role = "compare", actuator = "motor", field = "u", scale = 2.0, unit = "N m", noise = 0.01},
]
"""


def angle(time: np.ndarray, derivative: int = 0) -> np.ndarray:
    return sum(a * w**derivative * np.sin(w * time + derivative * np.pi / 2) for a, w in ((0.6, 1.3), (0.3, 4.1)))


@cache
def folder() -> Path:
    """Everything that the command wrote; two logs of the same name."""
    out = Path(mkdtemp())
    (out / "one.xml").write_text(MODEL)
    (out / "map.toml").write_text(MAP)
    rng = np.random.default_rng(0)
    for name, begin in (("learnt", 0.0), ("judged", 3.0)):
        time = np.arange(begin, begin + 11, 0.01)
        torque = INERTIA * angle(time, 2) + DAMPING * angle(time, 1) + NOISE * rng.standard_normal(len(time))
        rows = "\n".join(f"{1e3 * t:.1f},{angle(t):.8f},{u / 2:.8f}" for t, u in zip(time, torque))
        (out / name).mkdir()
        (out / name / LOG).write_text("t,q,u\n" + rows + "\n")
    given = [f"learnt/{LOG}", "--holdout", f"judged/{LOG}", "--map", "map.toml"]
    command = [
        sys.executable,
        "-m",
        "boom_mj",
        "gap",
        "diagnose",
        *given,
        "--html",
        "page.html",
        "--predictions",
        "twins",
    ]
    done = subprocess.run(command, capture_output=True, text=True, cwd=out, env={"PYTHONPATH": str(ROOT)}, timeout=300)
    assert done.returncode == 0, done.stderr
    return out


def test_the_page_knows_no_boom() -> None:
    text = (folder() / "page.html").read_text()
    reader = Reader(text)
    words = " ".join("".join(reader.words).split())
    assert len(reader.values("id")) == len(set(reader.values("id")))
    assert {"where", "machine", "ladder", "overlays", "change", "left"} <= set(reader.values("id"))
    assert not {"b", "script", "link", "img"} & set(reader.tags)
    assert all(value.startswith("#") for value in links(reader))
    assert "pendulum <b>" in words and "a<b>&" in words
    assert "Viscous joint friction (joint swing) explains the gap" in words
    assert "q: its measured motion drives" in words and "torque: judged" in words
    body = text[text.index("<body>") :].replace("boom_mj", "")
    assert [word for word in ("boom", "cylinder", "marker", "hinge", "None", "nan") if word in body] == []


@pytest.mark.parametrize(("kind", "damping"), [("nominal", 0.0), ("corrected", DAMPING)])
@pytest.mark.parametrize(("log", "begin"), [("a<b>&", 0.0), ("a<b>&-2", 3.0)])
def test_simulated_recordings_say_what_theory_says(kind: str, damping: float, log: str, begin: float) -> None:
    """Inertia times acceleration, and damping times speed, to the noise but where filters meet a stretch's ends."""
    table = read_columns(folder() / "twins" / f"{log}.{kind}.csv", ["time [s]", "torque [N m]"])
    time, torque = table["time [s]"], table["torque [N m]"]
    assert begin < time[0] < begin + 1 and len(time) > 800
    expected = INERTIA * angle(time, 2) + damping * angle(time, 1)
    assert float(np.quantile(np.abs(torque - expected), 0.9)) < NOISE
