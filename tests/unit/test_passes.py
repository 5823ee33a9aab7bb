"""Passes of one motion share the model's error: more of them make an interval no narrower."""

from pathlib import Path

import numpy as np

from boom_mj.diagnosis.candidate import Candidate
from boom_mj.diagnosis.fitting import fit
from boom_mj.diagnosis.linearisation import linearise
from boom_mj.diagnosis.scoring import deviations, score
from boom_mj.effects import effect_library
from boom_mj.systems.mjcf import load_mjcf
from boom_mj.systems.predictor import Predictor

MODEL = """<mujoco><option gravity="0 0 0"/><worldbody><body name="arm"><joint name="swing"/>
<geom size="0.1" mass="1" pos="1 0 0"/></body></worldbody>
<actuator><motor name="motor" joint="swing"/></actuator></mujoco>"""
MAP = """
name = "pendulum"
time = "t"
model = "one.xml"
window = 4.0
start = 0.5
repeat = 4.0
independent = 0.3 # no whole part of a period, over which the ripple would cancel
channel = [
  {name = "q", role = "drive", joint = "swing", field = "q", unit = "rad"},
  {name = "torque", role = "compare", actuator = "motor", field = "u", unit = "N m"},
]
"""


def deviation(folder: Path, passes: int) -> float:
    """Of a damping beside a ripple of 1.5 Hz that no effect knows, the same in every pass."""
    (folder / "one.xml").write_text(MODEL)
    (folder / "map.toml").write_text(MAP)
    time = np.arange(0, 4.0 * passes + 1, 0.01)
    w, rng = np.pi, np.random.default_rng(0)
    torque = -1.004 * 0.5 * w**2 * np.sin(w * time) + 0.25 * w * np.cos(w * time) + 0.3 * np.cos(3 * w * time)
    torque += 0.01 * rng.standard_normal(len(time))
    rows = "\n".join(f"{t:.2f},{0.5 * np.sin(w * t):.8f},{u:.8f}" for t, u in zip(time, torque))
    (folder / "log.csv").write_text("t,q,u\n" + rows + "\n")
    given = load_mjcf([folder / "log.csv"], [folder / "log.csv"], folder / "map.toml")
    system, data = given.system, given.data
    kind = effect_library()["viscous_joint_friction"]
    (site,) = kind.allowed(system.sites())
    model = linearise(Predictor(system, data))
    found = score(model, fit(model, Candidate((kind(site, damping=0.4),))))
    return float(deviations(model, found.fit)[0])


def test_more_passes_of_the_same_error_tell_no_more(tmp_path: Path) -> None:
    few, many = deviation(tmp_path, 3), deviation(tmp_path, 12)
    assert many > 0.8 * few  # independent windows would halve it
