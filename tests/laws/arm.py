"""An MJCF machine that has every kind of site, and a log of it."""

from functools import cache
from pathlib import Path
from tempfile import mkdtemp

import numpy as np

from boom_mj.systems.mjcf import MjcfSystem, load_mjcf
from boom_mj.systems.predictor import Predictor

ARM = """
<mujoco model="arm">
  <option timestep="0.002" integrator="implicitfast"/>
  <worldbody>
    <body name="upper" pos="0 0 1">
      <joint name="shoulder" axis="0 1 0" damping="0.1" armature="0.01" frictionloss="0.2"/>
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
  {name = "angle", role = "drive", joint = "shoulder", field = "q", unit = "rad", zero = 1e-3},
  {name = "bend", role = "compare", joint = "flex", field = "bend", unit = "rad", noise = 1e-4, zero = 1e-3},
  {name = "torque", role = "compare", actuator = "motor", field = "tau", unit = "N m", noise = 1e-2},
  {name = "push", role = "control", actuator = "spinner", field = "u", unit = "N m"},
  {name = "sag", role = "compare", sensor = "reed_tip", component = 2, field = "q", unit = "m"},
  {name = "turn", role = "compare", joint = "spin", field = "turn", unit = "rad", noise = 1e-3},
]
"""


@cache
def predictor() -> Predictor:
    """Of the log's stretches: two joints move, one as it is driven, one as it is commanded."""
    folder = Path(mkdtemp())
    (folder / "arm.xml").write_text(ARM)
    (folder / "map.toml").write_text(MAP)
    time = np.arange(0, 8.5, 0.005)
    angle = 0.4 * np.sin(2 * time) + 0.1 * np.sin(7 * time)
    push = 0.05 * np.sign(np.sin(3 * time)) * np.abs(np.sin(0.5 * time))
    columns = [time, angle, 0.03 * np.cos(time), 5 * np.cos(2 * time), push, 0.5 * np.sin(3 * time)]
    rows = "\n".join(",".join(f"{x:.9g}" for x in row) for row in zip(*columns))
    (folder / "log.csv").write_text("t,q,bend,tau,u,turn\n" + rows + "\n")
    given = load_mjcf([folder / "log.csv"], [], folder / "map.toml")
    return Predictor(given.system, given.data)


def system() -> MjcfSystem:
    """The machine."""
    found = predictor().system
    assert isinstance(found, MjcfSystem)
    return found
