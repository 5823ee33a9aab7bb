"""Laws that every effect of any machine obeys; a new file in `effects/general/` is tested the day it lands."""

from functools import cache
from pathlib import Path
from tempfile import mkdtemp

import numpy as np
import pytest

from boom_mj.diagnosis import Campaign
from boom_mj.effects import Effect
from boom_mj.effects.general_effect import SpecEffect, general_library
from boom_mj.systems.mjcf import MjcfSystem, robot_campaign
from boom_mj.systems.system import Level

ARM = """
<mujoco model="arm">
  <option timestep="0.002" integrator="implicitfast"/>
  <worldbody>
    <body name="upper" pos="0 0 1">
      <joint name="shoulder" axis="0 1 0" damping="0.1" armature="0.01"/>
      <geom type="capsule" fromto="0 0 0 0.4 0 0" size="0.03" mass="1"/>
      <body name="fore" pos="0.4 0 0">
        <joint name="flex" axis="0 1 0" stiffness="60" damping="0.2"/>
        <geom type="capsule" fromto="0 0 0 0.3 0 0" size="0.02" mass="0.4"/>
      </body>
    </body>
    <body name="wheel" pos="0 1 1">
      <joint name="spin" axis="0 0 1" damping="0.02"/>
      <geom type="cylinder" size="0.1 0.01" mass="0.5"/>
    </body>
    <body name="reed" pos="0 2 1">
      <joint name="reed/1" axis="0 1 0" stiffness="2" damping="0.01"/>
      <geom type="capsule" fromto="0 0 0 0.1 0 0" size="0.01" mass="0.1"/>
      <body name="reed_2" pos="0.1 0 0">
        <joint name="reed/2" axis="0 1 0" stiffness="2" damping="0.01"/>
        <geom type="capsule" fromto="0 0 0 0.1 0 0" size="0.01" mass="0.1"/>
        <site name="reed_tip" pos="0.1 0 0"/>
      </body>
    </body>
  </worldbody>
  <sensor><framepos name="reed_tip" objtype="site" objname="reed_tip"/></sensor>
  <actuator>
    <motor name="motor" joint="shoulder"/>
    <motor name="spinner" joint="spin"/>
  </actuator>
</mujoco>
"""
MAP = """
name = "arm"
model = "arm.xml"
time = "t"
window = 4.0
cutoff = 10.0
channel = [
  {name = "angle", role = "drive", joint = "shoulder", field = "q", unit = "rad"},
  {name = "bend", role = "compare", joint = "flex", field = "bend", unit = "rad", noise = 1e-4},
  {name = "torque", role = "compare", actuator = "motor", field = "tau", unit = "N m", noise = 1e-2},
  {name = "push", role = "control", actuator = "spinner", field = "u", unit = "N m"},
  {name = "sag", role = "compare", sensor = "reed_tip", component = 2, field = "q", unit = "m"},
  {name = "turn", role = "compare", joint = "spin", field = "turn", unit = "rad", noise = 1e-3},
]
"""


@cache
def campaign() -> Campaign:
    folder = Path(mkdtemp())
    (folder / "arm.xml").write_text(ARM)
    (folder / "map.toml").write_text(MAP)
    time = np.arange(0, 8.5, 0.005)
    angle = 0.4 * np.sin(2 * time) + 0.1 * np.sin(7 * time)
    push = 0.05 * np.sign(np.sin(3 * time)) * np.abs(np.sin(0.5 * time))
    columns = [time, angle, 0.03 * np.cos(time), 5 * np.cos(2 * time), push, 0.5 * np.sin(3 * time)]
    rows = "\n".join(",".join(f"{x:.9g}" for x in row) for row in zip(*columns))
    (folder / "log.csv").write_text("t,q,bend,tau,u,turn\n" + rows + "\n")
    return robot_campaign([folder / "log.csv"], [], folder / "map.toml")


def robot() -> MjcfSystem:
    subject = campaign().subject
    assert isinstance(subject, MjcfSystem)
    return subject


def placed() -> list[tuple[type[Effect], dict]]:
    return robot().library()


def called(kind: type[Effect], place: dict) -> str:
    return "-".join([kind.id, *map(str, place.values())])


def predicted(*effects: Effect) -> np.ndarray:
    return campaign().predict([effects], Level(1.0))[0]


@cache
def nominal() -> np.ndarray:
    return predicted()


@pytest.mark.parametrize("name", general_library())
def test_neutral_parameters_change_nothing(name: str) -> None:
    effects = [kind(place) for kind, place in placed() if kind.id == name]
    assert effects, f"{name} is nowhere on this machine"
    for effect in effects:
        if isinstance(effect, SpecEffect):
            spec = robot().spec.copy()
            effect.edit(spec)
            assert spec.to_xml() == robot().spec.to_xml(), effect
        assert np.array_equal(predicted(effect), nominal(), equal_nan=True), effect


@pytest.mark.parametrize("name", general_library())
def test_every_knob_moves_something(name: str) -> None:
    for kind, place in [row for row in placed() if row[0].id == name][:3]:
        values: dict[str, float] = {}
        for each in kind.probes(place)[-1]:
            values |= each
        probe = kind(place, **values)
        moved = predicted(probe)
        assert np.isfinite(moved).all() and np.abs(moved - nominal()).max() > 1e-9, probe
        for knob in kind.knobs(place):
            other = kind(place, **{**values, knob: kind.parameters[knob].neutral})
            assert np.abs(predicted(other) - moved).max() > 1e-12, f"{knob} of {probe}"


@pytest.mark.parametrize("name", general_library())
def test_it_says_what_it_is(name: str) -> None:
    kind = general_library()[name]
    assert kind.__doc__ and kind.confused_with and kind.told_by
    for alike in kind.confused_with:
        assert alike in general_library(), f"{name} is confused with {alike}, which there is not"


def test_commands_and_readings_have_inverses() -> None:
    time = np.arange(0, 10, 0.01)
    values = 2 + np.sin(time)
    for kind, place in placed():
        at_work = kind(place, **kind.probes(place)[0][0])
        for there, back in (("act", "command"), ("read", "true")):
            if hasattr(at_work, there) and kind.id != "quantisation":
                returned = getattr(at_work, back)(time, getattr(at_work, there)(time, values))
                assert np.abs(returned - values)[50:-50].max() < 0.02, at_work
