"""What a pendulum has and its MJCF lacks comes back by name and size, from a table and a channel map.

The machine that is measured is a MuJoCo model of its own, stepped four times finer, with noise on what it logs; a
stiff servo moves it along a motion that is no secret, and the diagnosis gets the table.
"""

from functools import cache
from pathlib import Path
from tempfile import mkdtemp
from typing import Any

import mujoco
import numpy as np
import pytest

from boom_mj.diagnosis import diagnose, document
from boom_mj.errors import LogWarning
from boom_mj.systems.mjcf import load_mjcf
from boom_mj.systems.predictor import Predictor

PENDULUM = """
<mujoco model="pendulum">
  <option timestep="0.002" integrator="implicitfast"/>
  <worldbody>
    <body name="arm" pos="0 0 1">
      <joint name="swing" axis="0 1 0" damping="{damping}" frictionloss="{friction}"
             solreffriction="0.001 1" solimpfriction="0.99 0.999 0.001"/>
      <geom type="capsule" fromto="0 0 0 0 0 -0.5" size="0.02" mass="1.0"/>
      <site name="tip" pos="0 0 -0.5"/>
      {load}
    </body>
  </worldbody>
  <actuator>{actuator}</actuator>
</mujoco>
"""
MOTOR = '<motor name="motor" joint="swing"/>'
SERVO = '<position name="motor" joint="swing" kp="400" kv="20"/>'
LOAD = '<body pos="0 0 -0.5"><geom type="sphere" size="0.001" mass="{mass}" contype="0" conaffinity="0"/></body>'
MAP = """
name = "pendulum"
model = "nominal.xml"
time = "time"
window = 4.0
start = 1.0 # the servo has caught up
cutoff = 8.0
settle = 0.5
[[channel]]
name = "angle"
role = "{drive}"
joint = "swing"
field = "angle"
unit = "rad"
noise = 1e-5
[[channel]]
name = "torque"
role = "{torque}"
actuator = "motor"
field = "torque"
unit = "N m"
"""
RATE, DURATION, FINER = 500, 20.0, 16


def motion(time: np.ndarray) -> np.ndarray:
    return 0.5 * np.sin(2 * np.pi * 0.31 * time) + 0.25 * np.sin(2 * np.pi * 0.83 * time + 1) - 0.25 * np.sin(1)


def measure(folder: Path, delay: float, **planted: float) -> Path:
    """A table of the machine's angle and of the torque that its servo was told to make."""
    load = LOAD.format(mass=planted["mass"]) if "mass" in planted else ""
    friction, damping = planted.get("friction", 0.0), 0.05
    text = PENDULUM.format(damping=damping, friction=friction, load=load, actuator=SERVO)
    text = text.replace('timestep="0.002"', f'timestep="{1 / RATE / FINER}"')
    model = mujoco.MjModel.from_xml_string(text.replace("implicitfast", "Euler"))  # the servo's force as it is logged
    data, rng = mujoco.MjData(model), np.random.default_rng(0)
    rows = []
    for k in range(int(RATE * DURATION)):
        before = float(data.qpos[0])
        for part in range(FINER):
            data.ctrl[0] = motion(np.array((k + part / FINER) / RATE))
            mujoco.mj_step(model, data)
            if part == 0:
                torque = float(data.actuator_force[0])
        rows.append((k / RATE, before, torque))
    time, angle, torque = np.array(rows).T
    told = np.interp(time + delay, time, torque)  # the motor acts late
    angle, told = angle + 1e-5 * rng.standard_normal(len(time)), told + 0.01 * rng.standard_normal(len(time))
    table = folder / "log.csv"
    lines = ["time,angle,torque", *(f"{t:.6f},{q:.8f},{u:.6f}" for t, q, u in zip(time, angle, told))]
    table.write_text("\n".join(lines) + "\n")
    return table


def spoil(table: Path, *sensed: int) -> None:
    """As loggers do: samples are missing, come twice or late, half a second is lost; those of sensors jump away."""
    rng = np.random.default_rng(1)
    header, *lines = table.read_text().splitlines()
    rows = [line.split(",") for line in lines]
    for k in rng.choice(np.arange(500, len(rows), 8), 40, replace=False):
        column = int(rng.integers(1, 3))
        rows[k][column] = rng.choice(["", "1000.0", "-1000.0"]) if column in sensed else ""
    rows = [row for k, row in enumerate(rows) for _ in range(1 + (k % 700 == 0)) if not 5200 <= k < 5450]
    rows[800], rows[803] = rows[803], rows[800]
    table.write_text("\n".join([header, *(",".join(row) for row in rows)]) + "\n")


@cache
def answer(
    drive: str = "drive", delay: float = 0.0, without: tuple[str, ...] = (), spoiled: bool = False, **planted: float
) -> dict[str, Any]:
    folder = Path(mkdtemp())
    (folder / "nominal.xml").write_text(PENDULUM.format(damping=0.05, friction=0.0, load="", actuator=MOTOR))
    torque = "compare" if drive == "drive" else "control"
    (folder / "map.toml").write_text(MAP.format(drive=drive, torque=torque))
    log = measure(folder, delay, **planted)
    if spoiled:
        spoil(log, 1, *[2] * (drive == "drive"))
    given = load_mjcf([log], [], folder / "map.toml")
    return document(diagnose(Predictor(given.system, given.data), without), given.names, given.findings)


def test_nothing_planted_nothing_found() -> None:
    found = answer()
    assert found["verdict"] == "consistent" and not found["effects"], found["sentence"]


def test_dry_friction_comes_back_and_not_as_damping() -> None:
    found = answer(friction=0.3)
    assert found["verdict"] == "explained", found["sentence"]
    (effect,) = found["effects"]
    assert (effect["id"], effect["location"]) == ("coulomb_friction", {"joint": "swing"})
    force = effect["parameters"]["force"]
    assert force["value"] == pytest.approx(0.3, rel=0.05) and force["low"] < 0.3 < force["high"]


@pytest.mark.parametrize("drive", ["drive", "compare"])
def test_a_spoiled_log_says_the_same(drive: str) -> None:
    """Of a joint that follows its measured motion, and of one that moves by itself."""
    with pytest.warns(LogWarning):
        found = answer(drive, spoiled=True, friction=0.3)
    kinds = {(finding["channel"], finding["kind"]) for finding in found["data"]}
    assert kinds >= {("angle", "spiky"), ("angle", "dropped"), ("torque", "dropped")}
    assert found["verdict"] == "explained", found["sentence"]
    (effect,), (same,) = found["effects"], answer(drive, friction=0.3)["effects"]
    assert effect["id"] == same["id"]
    force = effect["parameters"]["force"]
    assert force["value"] == pytest.approx(0.3, rel=0.05) and force["low"] < 0.3 < force["high"]


def test_dry_friction_that_is_withheld_is_no_damping() -> None:
    dry = ("coulomb_friction", "dry_and_viscous_friction", "asymmetric_friction", "stribeck_friction", "load_friction")
    kin = (*dry, "directional_friction", "dead_zone", "asymmetric_dead_zone", "backlash")
    found = answer(friction=0.3, without=kin)
    assert found["verdict"] == "unexplained" and not found["effects"], found["sentence"]
    assert "Another law resists joint swing" in found["sentence"]


def test_a_payload_comes_back() -> None:
    found = answer(mass=0.2)
    assert found["verdict"] in ("explained", "ambiguous"), found["sentence"]
    effect = found["effects"][0]
    assert effect["id"] == "payload" and effect["parameters"]["mass"]["value"] == pytest.approx(0.2, rel=0.05)


def test_an_actuator_that_acts_late_comes_back() -> None:
    found = answer(delay=0.03)
    ids = [effect["id"] for effect in found["effects"]] + [e["id"] for tie in found["ties"] for e in tie]
    assert "actuator_delay" in ids, found["sentence"]
    assert found["effects"][0]["parameters"]["delay"]["value"] == pytest.approx(0.03, abs=0.003)


def test_commands_can_drive_instead_of_motion() -> None:
    """The same friction, seen in the motion that a given torque makes."""
    found = answer("compare", friction=0.3)
    (effect,) = found["effects"]
    assert effect["id"] in ("coulomb_friction", "dry_and_viscous_friction"), found["sentence"]
    assert effect["parameters"]["force"]["value"] == pytest.approx(0.3, rel=0.05)
