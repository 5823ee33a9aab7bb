"""Topic maps: names, signs, offsets, units, roles and time bases; what is wrong in one is named."""

import warnings

import numpy as np
import pytest
from foreign import (
    ANGLES,
    JOINTS,
    TIME,
    angles_entry,
    joint_state,
    joint_states,
    log_of,
    proposed,
    read,
    ros2,
    write_mcap_channels,
)

from boom_mj.errors import LogError, LogWarning, TopicMapError
from boom_mj.logs import load_topic_map, read_log
from boom_mj.logs.inspection import inspect_log
from boom_mj.logs.proposal import propose_map
from boom_mj.logs.topic_map import Entry


def test_names_signs_offsets_and_degrees_are_taken_from_the_map(tmp_path):
    names = ("arm4", "pump", "arm1", "arm3", "slew", "arm2")
    logged = np.rad2deg(ANGLES[:, [4, 0, 1, 3, 0, 2]])
    logged[:, 4] = 90 - logged[:, 4]  # the slewing encoder counts backwards from 90 deg
    path = write_mcap_channels(tmp_path / "log.mcap", [ros2("/boom", joint_states(names, logged))])
    order = ("slew", "arm1", "arm2", "arm3", "arm4")
    entry = angles_entry(topic="/boom", source=order, unit="deg", sign=(-1, 1, 1, 1, 1), offset=(90, 0, 0, 0, 0))
    np.testing.assert_allclose(read(path, entry)["joint/position"].values, ANGLES, rtol=0, atol=1e-15)


def test_joints_from_topics_of_their_own_are_put_on_common_times_aloud(tmp_path):
    slew = joint_states(["slew"], ANGLES[:, :1], TIME + 0.005)
    rest = joint_states(JOINTS[1:], ANGLES[:, 1:])
    path = write_mcap_channels(tmp_path / "log.mcap", [ros2("/slew", slew), ros2("/joint_states", rest)])
    with pytest.warns(LogWarning, match="from /slew position are interpolated|from /joint_states position are interp"):
        found = read(path, angles_entry(topic="/slew", source="slew", to="joint1"), angles_entry(to=JOINTS[1:]))[
            "joint/position"
        ]
    np.testing.assert_allclose(
        found.values[1:-1],
        np.stack([np.interp(found.time[1:-1], TIME + 0.005 * (i == 0), ANGLES[:, i]) for i in range(5)], 1),
        atol=2e-6,  # a double holds such times to 2e-7 s
    )


def test_parts_that_share_their_times_are_not_interpolated(tmp_path):
    slew, rest = joint_states(["slew"], ANGLES[:, :1]), joint_states(JOINTS[1:], ANGLES[5:, 1:], TIME[5:])
    path = write_mcap_channels(tmp_path / "log.mcap", [ros2("/slew", slew), ros2("/joint_states", rest)])
    with warnings.catch_warnings():
        warnings.simplefilter("error", LogWarning)
        found = read(path, angles_entry(topic="/slew", source="slew", to="joint1"), angles_entry(to=JOINTS[1:]))
    np.testing.assert_array_equal(found["joint/position"].values, ANGLES[5:])


def test_two_publishers_of_different_joints_on_one_topic_go_together(tmp_path):
    parts = (joint_states(JOINTS[:2], ANGLES[:, :2]), joint_states(JOINTS[2:], ANGLES[:, 2:]))
    path = write_mcap_channels(tmp_path / "log.mcap", [ros2("/joint_states", part) for part in parts])
    for topic_map in (None, proposed(path, tmp_path)):
        np.testing.assert_array_equal(read_log(path, topic_map)["joint/position"].values, ANGLES)


def test_rival_publishers_are_refused_until_one_is_chosen(tmp_path):
    pair = [ros2("/joint_states", joint_states(angles=ANGLES + shift)) for shift in (0, 1)]
    path = write_mcap_channels(tmp_path / "log.mcap", pair)
    with pytest.raises(LogError, match=r"log\.mcap, topic /joint_states: two publishers \(1 and 2\).*publisher = 1"):
        read_log(path)
    np.testing.assert_array_equal(read(path, angles_entry(publisher=2))["joint/position"].values, ANGLES + 1)
    np.testing.assert_array_equal(read_log(path, proposed(path, tmp_path))["joint/position"].values, ANGLES)


def test_a_joint_that_the_log_lacks_can_be_given_as_a_constant(tmp_path):
    path = write_mcap_channels(tmp_path / "log.mcap", [ros2("/joint_states", joint_states(JOINTS[1:], ANGLES[:, 1:]))])
    with pytest.raises(LogError, match="topic /joint_states: joint1 missing; present are joint2, joint3"):
        read_log(path)
    still = Entry(signal="joint/position", to="joint1", constant=90.0, unit="deg")
    found = read(path, angles_entry(to=JOINTS[1:]), still)["joint/position"].values
    np.testing.assert_array_equal(found[:, 1:], ANGLES[:, 1:])
    np.testing.assert_array_equal(found[:, 0], np.pi / 2)
    assert '# to = ["joint1"]' in propose_map(inspect_log(path))


def test_commands_may_stand_for_measured_angles_but_not_silently(tmp_path):
    path = write_mcap_channels(tmp_path / "log.mcap", [ros2("/cmd", joint_states())])
    with pytest.warns(LogWarning, match="'joint/position' is what was commanded, not measured"):
        read(path, angles_entry(topic="/cmd", role="commanded"))


def test_times_of_recording_or_of_a_field_can_be_the_time_base(tmp_path):
    stopped = [joint_state(0.0, JOINTS, row) for row in ANGLES]
    path = log_of(tmp_path, stopped)
    with pytest.raises(LogError, match='all header stamps are 0; say time = "log"'):
        read_log(path)
    assert inspect_log(path).topics[0].time_base == "log"
    np.testing.assert_array_equal(read(path, angles_entry(time="log"))["joint/position"].time, TIME)
    table = tmp_path / "log.csv"
    table.write_text("ms,a,b,c,d,e\n" + "\n".join(f"{20 * i},0,0,0,0,{i}" for i in range(50)))
    entry = angles_entry(topic="table", field="columns", source=tuple("abcde"), unit="deg", time="ms", time_unit="ms")
    np.testing.assert_allclose(read(table, entry)["joint/position"].time, np.arange(50) / 50)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", "holds nothing"),
        ("[[entry]\n", "not a TOML file"),
        ("[entry]\n", r"holds \[\[entry\]\] tables"),
        ("[[entry]]\nsignal = 1\n", "entry 1: signal"),
        ('[[entry]]\nsignal = "joint/angle"\nunit = "rad"\n', "the signals are joint/position"),
        ('[[entry]]\nunit = "rad"\nsignal = "joint/position"\n', "either a topic and a field, or a constant"),
        ('unit = "deg?"', r'unit = "deg\?" is a guess: check it and take the question mark away \(rad, deg'),
        ('unit = "bar"', 'unit = "bar" is none of rad, deg'),
        ('time_unit = "min"', 'time_unit = "min" is none of s, ms'),
        ("sign = [1, 2, 1, 1, 1]", r"entry 1: sign\.1 = 2"),
        ("sign = [1, -1]", "sign has 2 entries for the channels joint1"),
        ('to = ["joint9"]', "to names joint9; channels are joint1"),
        ('from = ["a", "b"]', "from has 2 entries"),
        ('role = "guessed"', "role = 'guessed'"),
        ('signal = "joint_command/position"', "is commanded, not measured"),
        ("gain = 2", "gain is an unknown key; known are signal, unit, topic, field, from, to"),
    ],
)
def test_what_is_wrong_in_a_map_is_named_with_what_is_allowed(text, says, tmp_path):
    usual = {"signal": '"joint/position"', "topic": '"/j"', "field": '"position"', "unit": '"rad"'}
    if text and "entry]" not in text:
        key, _, value = text.partition(" = ")
        text = "[[entry]]\n" + "\n".join(f"{k} = {v}" for k, v in (usual | {key: value}).items())
    (tmp_path / "map.toml").write_text(text)
    with pytest.raises(TopicMapError, match=rf"map\.toml.*{says}"):
        load_topic_map(tmp_path / "map.toml")
    with pytest.raises(TopicMapError, match="nowhere"):
        load_topic_map(tmp_path / "nowhere.toml")
