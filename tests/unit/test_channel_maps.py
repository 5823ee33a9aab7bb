"""A channel map that is wrong is refused by the name of its channel, with what would be right."""

from pathlib import Path

import numpy as np
import pytest
from scipy.io import savemat

from boom_mj.effects import Parameter
from boom_mj.effects.laws import TEMPERATURE, ChannelLaw
from boom_mj.errors import ChannelMapError, LogError
from boom_mj.logs.columns import read_columns
from boom_mj.systems.mjcf import load_mjcf
from boom_mj.systems.mjcf.channel_map import parse_channel_map
from boom_mj.systems.mjcf.model_file import load_model
from boom_mj.systems.mjcf.segments import UNSURE

MODEL = """<mujoco><worldbody><body><joint name="swing"/><geom size="0.1" mass="1" pos="0 0 -1"/></body></worldbody>
<actuator><motor name="motor" joint="swing"/></actuator></mujoco>"""
GOOD = """
name = "one"
time = "t"
model = "one.xml"
channel = [
  {name = "q", role = "drive", joint = "swing", field = "q"},
  {name = "u", role = "compare", actuator = "motor", field = "u"},
]
"""


WARM = '{{name = "{}", role = "temperature", joint = "swing", field = "q"}}'


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('name = "u"', 'name = "q"', "several channels are called q"),
        ('role = "compare"', 'role = "judge"', "'drive', 'control', 'compare' or 'temperature'"),
        ('role = "drive", joint = "swing"', 'role = "temperature", actuator = "motor"', "it may name a joint, nothing"),
        ("channel = [", f"channel = [{WARM.format('a')}, {WARM.format('b')},", "the temperature of swing"),
        ('actuator = "motor"', 'actuator = "motor", joint = "swing"', "just one of joint, actuator and sensor"),
        ('field = "u"', "scale = 2", "either a field or terms"),
        ('joint = "swing"', 'actuator = "motor"', "must name a joint"),
        ('field = "u"', 'field = "u", quantity = "position"', "none of force"),
        ('time = "t"', 'time = "t"\nspeed = 3', "unknown key; known are name, time"),
        ('time = "t"', "", "time is missing"),
        ('role = "compare"', 'role = "control"', "nothing to judge by"),
        ('time = "t"', "time = ", "not a TOML file"),
    ],
)
def test_bad_maps(old: str, new: str, said: str) -> None:
    with pytest.raises(ChannelMapError, match=said):
        parse_channel_map(GOOD.replace(old, new))


def files(folder: Path, text: str = GOOD) -> Path:
    (folder / "one.xml").write_text(MODEL)
    (folder / "map.toml").write_text(text)
    time = np.arange(0, 20, 0.01)
    rows = "\n".join(f"{t:.3f},{np.sin(t):.6f},{np.cos(t):.6f}" for t in time)
    (folder / "log.csv").write_text("t,q,u\n" + rows + "\n")
    return folder / "map.toml"


def test_names_that_the_model_does_not_have(tmp_path: Path) -> None:
    path = files(tmp_path, GOOD.replace('joint = "swing"', 'joint = "sling"'))
    with pytest.raises(ChannelMapError, match=r"'q': joint = 'sling' .* it has swing"):
        load_mjcf([tmp_path / "log.csv"], [], path)


def test_fields_that_the_log_does_not_have(tmp_path: Path) -> None:
    path = files(tmp_path, GOOD.replace('field = "u"', 'field = "torque"'))
    with pytest.raises(LogError, match=r"no field 'torque': .* none of q, t, u"):
        load_mjcf([tmp_path / "log.csv"], [], path)


def test_a_log_is_split_in_stretches(tmp_path: Path) -> None:
    path = files(tmp_path)
    data = load_mjcf([tmp_path / "log.csv"], [], path).data
    assert data.training == 1 and len(data.recordings) == 2
    names = [log.name for log in data.recordings]
    assert names[0].startswith("log.csv 0.2-10.2 s")
    apart = load_mjcf([tmp_path / "log.csv"], [tmp_path / "log.csv"], path).data
    assert (apart.training, len(apart.recordings)) == (2, 4)


def test_a_stretch_is_simulated_from_before_it(tmp_path: Path) -> None:
    """Nothing is lost for it but the log's own beginning."""
    path = files(tmp_path, GOOD.replace('time = "t"', 'time = "t"\nwindow = 4.0\nsettle = 3.0'))
    data = load_mjcf([tmp_path / "log.csv"], [], path).data
    for number, log in enumerate(data.recordings):
        begin = 0.2 + 3.0 + 4.0 * number
        assert log["u"].time[0] == pytest.approx(begin, abs=0.011) and log["u"].time[-1] < begin + 4.0
        assert log["start"].time[0] == pytest.approx(begin - 3.0 - 0.2) and log["q"].time[0] < begin - 3.0
    assert number == 3
    path = files(tmp_path, GOOD.replace('time = "t"', 'time = "t"\nsettle = 15.0'))
    with pytest.raises(LogError, match=r"too short for a window of 10.0 s that begins 15.0 s late"):
        load_mjcf([tmp_path / "log.csv"], [], path)


def test_of_measured_motion_the_noise_is_known(tmp_path: Path) -> None:
    """White noise through the filter, as theory has it: of a position, and of its rate."""
    text = GOOD.replace(
        '"drive", joint = "swing", field = "q"', '"compare", joint = "swing", field = "q", noise = 0.01'
    )
    path = files(tmp_path, text.replace('"compare", actuator', '"control", actuator'))
    given = load_mjcf([tmp_path / "log.csv"], [], path)
    system, data = given.system, given.data
    deviation, rate = data.recordings[0][UNSURE + "swing"].values[0]
    share = system.channels.cutoff / (0.5 / 0.01)  # of white noise below the cutoff
    assert deviation == pytest.approx(0.01 * np.sqrt(share), rel=0.1)
    assert rate == pytest.approx(deviation * 2 * np.pi * system.channels.cutoff / np.sqrt(3), rel=0.15)
    ladder, log = system.facts.fidelity, data.recordings[0]
    here, moved = (system.simulate((), level, log)["q"].values for level in (ladder.middle, ladder.starts[0]))
    assert moved[0] - here[0] == pytest.approx(deviation) and len(ladder.starts) == 2


def test_a_joint_whose_log_lacks_a_sample_begins_as_it_was_measured(tmp_path: Path) -> None:
    text = GOOD.replace('"compare", actuator', '"control", actuator').replace('"drive"', '"compare"')
    path = files(tmp_path, text)
    rows = (tmp_path / "log.csv").read_text().splitlines()
    rows[7] = rows[7].split(",")[0] + ",nan," + rows[7].split(",")[2]
    (tmp_path / "log.csv").write_text("\n".join(rows))
    given = load_mjcf([tmp_path / "log.csv"], [], path)
    system, data = given.system, given.data
    log, ladder = data.recordings[0], system.facts.fidelity
    here, moved = (system.simulate((), level, log)["q"].values for level in (ladder.middle, ladder.starts[0]))
    assert here[0] == pytest.approx(np.sin(0.2), abs=1e-4) and moved[0] != here[0]


def test_columns_of_tables_and_matlab_files(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text('time,position\n0,"[1.0, 2.0]"\n1,"[3.0, 4.0]"\n')
    assert read_columns(tmp_path / "a.csv", ["position[1]"])["position[1]"].tolist() == [2, 4]
    savemat(tmp_path / "a.mat", {"Scope": {"time": np.arange(3.0), "values": np.arange(6.0).reshape(3, 2)}})
    found = read_columns(tmp_path / "a.mat", ["Scope.time", "Scope.values[1]"])
    assert found["Scope.values[1]"].tolist() == [1, 3, 5]
    for field, said in (("Scope.values[2]", "no column 2"), ("Scope.values", "name a column"), ("x", "none of Scope")):
        with pytest.raises(LogError, match=said):
            read_columns(tmp_path / "a.mat", [field])
    (tmp_path / "b.mat").write_bytes(b"nothing of the kind" * 20)
    with pytest.raises(LogError, match="no MATLAB file"):
        read_columns(tmp_path / "b.mat", ["x"])


def test_bodies_and_joints_without_a_name_get_their_numbers(tmp_path: Path) -> None:
    link = "<joint/><geom size='.1'/>"
    text = f"<mujoco><worldbody><body>{link}<body name='hand'>{link}</body></body></worldbody></mujoco>"
    (tmp_path / "arm.xml").write_text(text)
    model = load_model(tmp_path / "arm.xml").compile()
    assert [model.body(k).name for k in range(model.nbody)] == ["world", "body 1", "hand"]
    assert [model.joint(k).name for k in range(model.njnt)] == ["joint 0", "joint 1"]


class WarmGauge(ChannelLaw):
    """A gauge whose gain follows its joint's temperature."""

    id = "test_warm_gauge"
    variables = ChannelLaw.variables | TEMPERATURE
    table = {"gain": Parameter("1/K", 0.0, -1.0, 1.0, 0.1)}

    def law(self, reading: np.ndarray, time: np.ndarray, temperature: np.ndarray, gain: float) -> np.ndarray:
        return gain * temperature * reading


def test_a_channel_reads_as_its_joints_logged_temperature_says(tmp_path: Path) -> None:
    path = files(tmp_path, GOOD.replace("channel = [", f"channel = [{WARM.format('heat')},"))
    given = load_mjcf([tmp_path / "log.csv"], [], path)
    system, data = given.system, given.data
    (site,) = WarmGauge.allowed(system.sites())
    log = data.recordings[1]
    dense = system.simulate((), system.facts.fidelity.rough, log)
    heard = system.observe((WarmGauge(site, gain=0.1),), dense)["u"]
    warm = np.sin(heard.time + log["start"].time[0])[:, None]  # what the log has as temperature
    np.testing.assert_allclose(heard.values, dense["u"].values * (1 + 0.1 * warm), atol=1e-4)
    assert set(data.recordings[0].signals) >= {"heat"} and "heat" not in system.facts.noise
