"""What a channel map says of single logs: when they start and stop, and numbers of the model that differ in them."""

from pathlib import Path

import mujoco
import numpy as np
import pytest

from boom_mj.errors import ChannelMapError
from boom_mj.systems.mjcf.channel_map import parse_channel_map
from boom_mj.systems.mjcf.log_table import read_table
from boom_mj.systems.mjcf.segments import stretches_of
from boom_mj.systems.mjcf.settings import with_settings
from boom_mj.systems.mjcf.system import BASE, MjcfSystem

MODEL = """<mujoco><worldbody><body name="cart"><joint name="slide" type="slide" axis="1 0 0" damping="1"/>
<geom name="box" type="box" size="1 1 1" mass="2"/></body></worldbody>
<actuator><position name="servo" joint="slide" kp="3" kv="4"/></actuator></mujoco>"""
MAP = """
name = "cart"
time = "t"
window = 2.0
block = 0.1
[[channel]]
name = "set point"
role = "control"
actuator = "servo"
field = "u"
[[channel]]
name = "cart"
role = "compare"
joint = "slide"
field = "x"
unit = "m"
noise = 1e-3
[[log]]
file = "loaded/a.csv"
start = 1.0
stop = 5.0
set = { "body cart.payload" = 2.0, "actuator servo.kp" = 6.0 }
"""


def spec() -> mujoco.MjSpec:
    return mujoco.MjSpec.from_string(MODEL)


def test_numbers_of_the_model_are_set_in_a_copy() -> None:
    settings = {
        "joint slide.damping": 7.0,
        "actuator servo.kp": 5.0,
        "body cart.payload": 1.5,
        "option.gravity": (0, 0, 1),
    }
    nominal = spec()
    model = with_settings(nominal, settings).compile()
    assert model.dof_damping[0] == 7.0
    assert (model.actuator_gainprm[0, 0], model.actuator_biasprm[0, 1], model.actuator_biasprm[0, 2]) == (
        5.0,
        -5.0,
        -4.0,
    )
    assert model.body_subtreemass[0] == pytest.approx(3.5)
    assert tuple(model.opt.gravity) == (0, 0, 1)
    assert nominal.compile().dof_damping[0] == 1.0


@pytest.mark.parametrize(
    ("key", "says"),
    [("wheel x.a", "joint, body"), ("joint x.damping", "no joint 'x'"), ("joint slide.colour", "'colour'")],
)
def test_what_the_model_lacks_is_named(key: str, says: str) -> None:
    with pytest.raises(ChannelMapError, match=says):
        with_settings(spec(), {key: 1.0})


def test_an_entry_goes_by_the_end_of_a_path(tmp_path: Path) -> None:
    channels = parse_channel_map(MAP)
    assert channels.of_log("/x/loaded/a.csv").stop == 5.0
    assert channels.of_log("/x/a.csv").set == {}


def test_a_told_load_and_step_are_in_the_nominal_model_of_its_log_alone(tmp_path: Path) -> None:
    told = MAP.replace('"actuator servo.kp" = 6.0', '"actuator servo.kp" = 6.0, "option.timestep" = 0.004')
    channels, time = parse_channel_map(told), np.arange(0, 6, 0.01)
    rows = np.stack([time, np.sin(time), np.sin(time)], axis=1)
    runs = {}
    for name in ("loaded/a.csv", "b.csv"):
        path = tmp_path / name
        path.parent.mkdir(exist_ok=True)
        np.savetxt(path, rows, delimiter=",", header="t,u,x", comments="")
        runs[name] = stretches_of(read_table(path, channels))
    assert [len(parts) for parts in runs.values()] == [2, 3]
    assert runs["loaded/a.csv"][0]["start"].time[0] == pytest.approx(1.0)
    system = MjcfSystem(spec(), channels, [*runs["loaded/a.csv"], *runs["b.csv"]], {"cart": 1e-3})
    masses = [system._model((), BASE, runs[name][0].description).body_subtreemass[0] for name in runs]
    assert masses == pytest.approx([4.0, 2.0])
    steps = [system.run((), BASE, runs[name][0]).time[1] for name in runs]
    assert steps == pytest.approx([0.004, 0.002])


def test_jumps_of_a_turn_are_undone(tmp_path: Path) -> None:
    channels = parse_channel_map(MAP.replace('unit = "m"', 'unit = "m"\nwrap = 1.5\nscale = 2.0'))
    time, path = np.arange(0, 6, 0.01), tmp_path / "b.csv"
    rows = np.stack([time, time, (0.7 * time) % 1.5], axis=1)
    np.savetxt(path, rows, delimiter=",", header="t,u,x", comments="")
    for part in stretches_of(read_table(path, channels)):
        assert part["cart"].values[:, 0] == pytest.approx(1.4 * part["cart"].time)
