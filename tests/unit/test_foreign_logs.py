"""Logs from elsewhere: the same angles come out of every format; what is wrong is handled aloud or refused by name."""

import json
import subprocess
import sys
import warnings
from pathlib import Path

import foreign
import numpy as np
import pytest
from foreign import ANGLES, JOINTS, START, TIME, imu, joint_state, joint_states, ros2, write_mcap_channels
from hypothesis import given, settings
from hypothesis import strategies as st
from mcap.writer import CompressionType
from rosbags.rosbag2 import Reader as Ros2Reader
from rosbags.typesys import Stores, get_typestore

from boom_mj.errors import LogError, LogWarning, TopicMapError
from boom_mj.logs import load_topic_map, read_log, write_mcap
from boom_mj.logs.channel import Channel
from boom_mj.logs.encodings import decoder_of
from boom_mj.logs.inspection import inspect_log
from boom_mj.logs.messages import typestore
from boom_mj.logs.proposal import propose_map
from boom_mj.logs.topic_map import Entry, TopicMap
from boom_mj.recording import QUANTITIES, Recording, named_signal


def angles_entry(**changes) -> Entry:
    usual = {"signal": "joint/position", "topic": "/joint_states", "field": "position", "unit": "rad"}
    return Entry(**(usual | changes))


def read(path: Path, *entries: Entry) -> Recording:
    return read_log(path, TopicMap(entries))


def proposed(path: Path, tmp_path: Path) -> TopicMap:
    """The proposed map, its guesses taken as right."""
    file = tmp_path / "map.toml"
    file.write_text(propose_map(inspect_log(path)).replace('?"', '"'))
    return load_topic_map(file)


@pytest.mark.parametrize("writer", foreign.WRITERS, ids=lambda writer: writer.__name__)
def test_every_format_gives_the_same_angles_through_its_proposed_map(writer, tmp_path):
    path = writer(tmp_path)
    with warnings.catch_warnings():
        warnings.simplefilter("error", LogWarning)
        found = read_log(path, proposed(path, tmp_path))["joint/position"]
    np.testing.assert_array_equal(found.values, ANGLES)
    # the log keeps ns, but a column of seconds since 1970 only what a double can hold
    np.testing.assert_allclose(found.time, TIME, rtol=0, atol=5e-7)


@pytest.mark.parametrize("writer", [foreign.from_msg, foreign.from_idl, foreign.from_ros2_bag, foreign.from_database])
def test_logs_with_our_topics_need_no_map(writer, tmp_path):
    np.testing.assert_array_equal(read_log(writer(tmp_path))["joint/position"].values, ANGLES)


def test_a_folder_with_one_file_is_that_file_even_without_its_metadata(tmp_path):
    foreign.from_msg(tmp_path)
    np.testing.assert_array_equal(read_log(tmp_path)["joint/position"].values, ANGLES)
    (bag := foreign.from_ros2_bag(tmp_path)).joinpath("metadata.yaml").unlink()
    np.testing.assert_array_equal(read_log(bag)["joint/position"].values, ANGLES)
    (bag / "ros2.db3").unlink()
    with pytest.raises(LogError, match="ros2 is not an MCAP file, nor one of ROS 1 bag, ROS 2 bag, CSV table"):
        read_log(bag)


def test_a_cut_in_a_chunk_says_how_much_of_it_is_lost(tmp_path):
    channel = ros2("/joint_states", joint_states())
    path = write_mcap_channels(tmp_path / "log.mcap", [channel], compression=CompressionType.NONE)
    path.write_bytes(path.read_bytes()[:12000])
    says = r"is cut off: \d+ messages .* went on to 1700000002\.000 s: 0\.\d+ s \(\d+ of its \d+ bytes\) are lost"
    with pytest.warns(LogWarning, match=says):
        found = read_log(path)["joint/position"].values
    assert 20 < len(found) < 100
    np.testing.assert_array_equal(found, ANGLES[: len(found)])


def test_a_file_that_lost_its_middle_is_damaged_not_cut_off(tmp_path):
    channel = ros2("/joint_states", joint_states())
    path = write_mcap_channels(tmp_path / "log.mcap", [channel], use_chunking=False)
    content = path.read_bytes()
    path.write_bytes(content[:5000] + content[-8:])  # the magic bytes that end a whole file
    with pytest.raises(LogError, match=r"log\.mcap is damaged, readable up to 17\d+\.\d+ s: a record of \d+ bytes"):
        read_log(path)


# --- CDR: all at once, like rosbags one by one -------------------------------------------------------------------

KINDS = ("sensor_msgs/msg/JointState", "sensor_msgs/msg/Imu", "geometry_msgs/msg/PoseArray",
         "geometry_msgs/msg/WrenchStamped", "trajectory_msgs/msg/JointTrajectory", "tf2_msgs/msg/TFMessage",
         "sensor_msgs/msg/BatteryState", "diagnostic_msgs/msg/DiagnosticArray")  # fmt: skip
SIZES = {"bool": 1, "byte": 127, "char": 255, "int8": 127, "uint8": 255, "int16": 999, "uint16": 999, "int32": 999,
         "uint32": 999, "int64": 999, "uint64": 999}  # fmt: skip


def random_value(description, rng):
    kind, detail = int(description[0]), description[1]
    if kind == 2:
        return random_message(detail, rng)
    if kind == 1:
        if detail[0] == "string":
            return "äöü boom"[: rng.integers(0, 9)]
        return float(np.float32(rng.normal())) if "float" in detail[0] else int(rng.integers(0, SIZES[detail[0]] + 1))
    element, count = detail[0], detail[1] if kind == 3 else int(rng.integers(0, 4))
    if int(element[0]) == 1 and element[1][0] != "string":
        return np.array([random_value(element, rng) for _ in range(count)], element[1][0].replace("byte", "uint8"))
    return [random_value(element, rng) for _ in range(count)]


def random_message(kind, rng):
    fields = typestore().fielddefs[kind][1]
    return typestore().types[kind](**{name: random_value(description, rng) for name, description in fields})


def numbers_of(message, path):
    """Numbers at a path, element by element: the slow way."""
    nodes = [message]
    for step in path.split("."):
        nodes = [getattr(node, step.removesuffix("[]")) for node in nodes]
        if step.endswith("[]"):
            nodes = [element for node in nodes for element in node]
    return [float(x) for node in nodes for x in _flat(node)]


def _flat(node):
    if hasattr(node, "x"):
        return [getattr(node, axis) for axis in "xyzw" if hasattr(node, axis)]
    return np.ravel(node)


PATHS = {
    KINDS[0]: ("position", "velocity", "effort"), KINDS[1]: ("orientation", "angular_velocity_covariance"),
    KINDS[2]: ("poses[].position", "poses[].orientation"), KINDS[3]: ("wrench.torque",),
    KINDS[4]: ("points[].time_from_start.sec",), KINDS[5]: ("transforms[].transform.translation",),
    KINDS[6]: ("voltage", "cell_voltage", "present"), KINDS[7]: ("status[].level",),
}  # fmt: skip


@settings(max_examples=60, deadline=None)
@given(
    kind=st.sampled_from(KINDS),
    seed=st.integers(0, 2**32 - 1),
    encoding=st.sampled_from(["cdr", "big-endian cdr", "ros1"]),
    count=st.integers(1, 12),
)
def test_messages_decoded_at_once_equal_those_that_rosbags_decodes(kind, seed, encoding, count):
    rng = np.random.default_rng(seed)
    messages = [random_message(kind, rng) for _ in range(count)]
    for message in messages:
        if kind == KINDS[0]:  # names and numbers go together, or there are no numbers
            message.name = [f"j{i}" for i in range(rng.integers(0, 3))]
            for field in ("position", "velocity", "effort"):
                setattr(message, field, rng.normal(size=len(message.name) * rng.integers(0, 2)))
    if encoding == "ros1":
        data = [bytes(typestore().serialize_ros1(message, kind)) for message in messages]
    else:
        little = encoding == "cdr"
        data = [bytes(typestore().serialize_cdr(message, kind, little_endian=little)) for message in messages]
    decoder = decoder_of(Channel(1, "/t", kind, encoding.rpartition(" ")[2]))
    seen = []
    for group in decoder.decode(data, PATHS[kind]):
        seen += list(group.which)
        for row, i in enumerate(group.which):
            decode = typestore().deserialize_ros1 if encoding == "ros1" else typestore().deserialize_cdr
            theirs = decode(data[i], kind)
            for path in PATHS[kind]:
                assert list(group.columns[path].values[row]) == numbers_of(theirs, path)
            if hasattr(theirs, "header"):
                assert group.stamp[row] == theirs.header.stamp.sec * 10**9 + theirs.header.stamp.nanosec
                assert group.frame_id == theirs.header.frame_id
    assert sorted(seen) == list(range(count))


# --- topic maps --------------------------------------------------------------------------------------------------


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


# --- faults ------------------------------------------------------------------------------------------------------


def log_of(path: Path, messages: list) -> Path:
    return write_mcap_channels(path / "log.mcap", [ros2("/joint_states", messages)])


def with_nan() -> list:
    angles = ANGLES.copy()
    angles[40:50, 3] = np.nan
    return joint_states(angles=angles)


@pytest.mark.parametrize(
    ("messages", "says"),
    [
        (with_nan(), r"joint4 of 'joint/position' is NaN at 1700000000\.800 s"),
        (joint_states(angles=np.rad2deg(ANGLES) + 300), r'joint\d is \d+ rad at .* unit = "deg" in a topic map'),
        (joint_states()[:30] + joint_states()[90:], r"hole of 1\.220 s after 1700000000\.580 s"),
        (joint_states(time=np.r_[TIME[:60], TIME[:41]]), r"clock was set back: 1700000001\.18\d+ s is followed by"),
        (joint_states(JOINTS[:3], ANGLES[:, :3]), "joint4, joint5 missing; present are joint1, joint2, joint3"),
        ([joint_state(t, JOINTS, ()) for t in TIME], None),
        (
            [*joint_states(), joint_state(START + 2.02, JOINTS[:4], [0] * 4)],
            r"joint5 missing in some.*1700000002\.020 s",
        ),
        ([*joint_states(), joint_state(START + 2.00, JOINTS, [0] * 5)], "with other values"),
        ([*joint_states(), joint_state(START + 2.02, JOINTS, [0, np.inf, 0, 0, 0])], "more than a turn|infinite"),
    ],
)
def test_joint_angles_are_whole_or_refused_with_file_topic_joint_and_time(messages, says, tmp_path):
    path = log_of(tmp_path, messages)
    if says is None:
        assert "joint/position" not in read_log(path)
        with pytest.raises(LogError, match="topic /joint_states: 'position' is empty in all messages"):
            read(path, angles_entry())
        return
    with pytest.raises(LogError, match=rf"log\.mcap, topic /joint_states: .*{says}"):
        read_log(path)


def late() -> list:
    messages = joint_states()
    return [*messages[:40], messages[41], messages[40], *messages[42:]]


@pytest.mark.parametrize(
    ("messages", "count", "says"),
    [
        (late(), 101, r"/joint_states: 1 messages, up to 20\.0 ms late, are put in their place"),
        ([m for m in joint_states() for _ in range(2)], 101, "101 repeated messages are dropped, the first at 17000"),
        (joint_states()[:30] + joint_states()[60:], 71, r"1 holes of up to 0\.620 s .* are bridged"),
        (
            joint_states(time=START + np.arange(101) / 15),
            101,
            r"at 15\.0 Hz have 30\.0 samples in a period of 0\.5 Hz and 8\.3 of 1\.8 Hz",
        ),
    ],
)
def test_flaws_that_do_not_stop_the_use_are_told(messages, count, says, tmp_path):
    path = log_of(tmp_path, messages)
    with pytest.warns(LogWarning, match=says):
        found = read_log(path)["joint/position"]
    assert len(found.time) == count
    assert (np.diff(found.time) > 0).all()


def test_samples_of_other_sensors_that_are_not_numbers_are_left_out_aloud(tmp_path):
    force = [(0.0, np.nan if 20 <= i < 30 else 9.81, 0.0) for i in range(101)]
    messages = [imu(t, "link3_tip", row) for t, row in zip(TIME, force)]
    path = write_mcap_channels(tmp_path / "log.mcap", [ros2("/imu/link3", messages)])
    with pytest.warns(
        LogWarning, match=r"/imu/link3: 10 of 101 samples of 'imu/link3/specific_force', from 17.*are NaN"
    ):
        found = read_log(path)
    assert found["imu/link3/specific_force"].values.shape == (91, 3)
    write_mcap(found, tmp_path / "copy.mcap")


def test_a_topic_or_field_that_is_not_there_is_named_with_those_that_are(tmp_path):
    path = log_of(tmp_path, joint_states())
    with pytest.raises(LogError, match="no messages on any of the topics /joints; it has /joint_states"):
        read(path, angles_entry(topic="/joints"))
    with pytest.raises(LogError, match="'angle' is empty in all messages"):
        read(path, angles_entry(field="angle"))
    with pytest.raises(LogError, match="j1, j2, j3, j4, j5 missing; present are joint1"):
        read(path, angles_entry(source=("j1", "j2", "j3", "j4", "j5")))
    with pytest.raises(LogError, match="name one of them"):
        read(path, angles_entry(field="header"))
    with pytest.raises(LogError, match=r"/elsewhere.* it has no messages; the log has /joint_states"):
        read(path, angles_entry(), Entry(signal="load", topic="/elsewhere", field="f", unit="N"))


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", "log.csv is empty"),
        ("0.0,1,2\n0.1,1,2\n", "no names in its first line"),
        ("t,a,a\n0,1,2\n", "several columns called 'a'"),
        ("t,a,b,c,d,e\n0,1,2\n", "row 1: 3 cells for the 6 columns"),
        ("t,a,b,c,d,e\n0,0,0,0,0,0\n1,0,,0,0,0\n", r"joint2 of 'joint/position' is NaN at 1\.000 s"),
        ("t,a,b,c,d,e\n0,0,0,0,0,0\nx,0,0,0,0,0\n", "the time field t is not always a number"),
        ("s,a,b,c,d,e\n0,0,0,0,0,0\n", "the time field t holds 0 numbers"),
    ],
)
def test_tables_are_refused_by_row_and_column(text, says, tmp_path):
    (tmp_path / "log.csv").write_text(text)
    entry = angles_entry(topic="table", field="columns", source=tuple("abcde"), time="t")
    with pytest.raises(LogError, match=says):
        read(tmp_path / "log.csv", entry)


# --- logs inspect ------------------------------------------------------------------------------------------------


def boom(*arguments: object) -> subprocess.CompletedProcess:
    command = [sys.executable, "-m", "boom_mj", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, timeout=300)


def test_inspect_says_what_is_wrong_with_the_times(tmp_path):
    messages = joint_states()
    odd = [*messages[:30], messages[29], *messages[60:], *messages[:5]]
    path = log_of(tmp_path, odd)
    topic = inspect_log(path).topics[0]
    assert topic.header.rate_hz == pytest.approx(50)
    assert (topic.header.repeated, topic.header.gaps, topic.header.resets) == (1, 1, 1)
    assert topic.header.longest_gap == pytest.approx(0.62)
    assert topic.header.longest_gap_at == pytest.approx(START + 0.58)
    assert topic.header.first_reset == pytest.approx(START + 2.0)
    assert (topic.log.repeated, topic.log.gaps, topic.log.resets) == (0, 0, 0)
    assert topic.time_base == "log"
    assert topic.fields["position"]["joint2"].least == ANGLES[:, 1].min()


def test_inspect_guesses_degrees_and_the_guess_is_not_accepted(tmp_path):
    path = log_of(tmp_path, joint_states(angles=np.rad2deg(ANGLES)))
    shown = boom("logs", "inspect", path)
    assert shown.returncode == 0, shown.stderr
    assert 'unit = "deg?"' in shown.stdout and "guess" in shown.stdout and "50.00 Hz" in shown.stdout
    (tmp_path / "map.toml").write_text(boom("logs", "inspect", path, "--map").stdout)
    with pytest.raises(TopicMapError, match="is a guess"):
        load_topic_map(tmp_path / "map.toml")
    found = read_log(path, proposed(path, tmp_path))["joint/position"].values
    np.testing.assert_allclose(found, ANGLES, rtol=0, atol=1e-15)
    document = json.loads(boom("logs", "inspect", path, "--json").stdout)
    assert document["topics"][0]["fields"]["position"]["joint1"]["max"] == pytest.approx(np.rad2deg(ANGLES[:, 0].max()))
    assert document["topics"][0]["header_time"]["rate_hz"] == pytest.approx(50)
    for arguments, status in (
        ((tmp_path / "no.mcap",), 2),
        ((path, "--json", "--map"), 2),
        ((tmp_path / "map.toml",), 1),
    ):
        done = boom("logs", "inspect", *arguments)
        assert done.returncode == status and done.stdout == "" and "Traceback" not in done.stderr


def test_columns_of_a_table_are_recognised_by_their_names_and_what_is_doubtful_is_said(tmp_path):
    names = ["Zeit", "Drehwerk", *(f"Arm{i}_deg" for i in range(1, 5)), "Arm1_soll_deg", "Zylinder2_Kraft_kN"]
    names += [f"link5_acc_{axis}_g" for axis in "xyz"]
    rows = [[1000 / 15 * i, 10.0, 60 + i / 90, -35, -40, -45, 60, 420.1, 0, 1, 0] for i in range(90)]
    lines = [";".join(f"{x:.3f}".replace(".", ",") for x in row) for row in rows]
    path = tmp_path / "messy.csv"
    path.write_text(";".join(names) + "\n" + "\n".join(lines) + "\n")
    text = propose_map(inspect_log(path))
    for line in (
        'from = ["Drehwerk", "Arm1_deg", "Arm2_deg", "Arm3_deg", "Arm4_deg"]',
        'unit = "deg?"',  # one of the names does not say so
        'time_unit = "ms?"',
        'unit = "g"',
        "# cylinder3 not found",
        '# from = ["Arm1_soll_deg"]',
    ):
        assert f"\n{line}" in text
    with pytest.warns(LogWarning, match="joint angles at 15.0 Hz"):
        found = read_log(path, proposed(path, tmp_path))
    assert set(found.signals) == {"joint/position", "imu/link5/specific_force"}
    np.testing.assert_allclose(found["joint/position"].values[0], np.deg2rad([10, 60, -35, -40, -45]))
    np.testing.assert_allclose(found["imu/link5/specific_force"].values[0], [0, 9.80665, 0])


def test_replay_takes_a_map(tmp_path):
    time = np.arange(0, 4, 0.02)
    angles = np.outer(np.ones_like(time), [0, 1.0, -0.5, -0.5, -0.5])
    path = log_of(tmp_path, joint_states(angles=np.rad2deg(angles), time=time))
    (tmp_path / "map.toml").write_text(propose_map(inspect_log(path)).replace('"deg?"', '"deg"'))
    done = boom("replay", path, "--map", tmp_path / "map.toml", "--machine", "boom36", "--json")
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["timing"]["simulated_s"] == pytest.approx(time[-1])
    refused = boom("replay", path, "--machine", "boom36")
    assert refused.returncode == 1 and "degrees" in refused.stderr and refused.stdout == ""


# --- our logs elsewhere, and broken ones here --------------------------------------------------------------------


def test_rosbags_reads_what_we_write_with_the_definitions_in_the_file(tmp_path):
    time = np.arange(20) / 50
    signals = {
        name: named_signal(name, time, np.random.default_rng(i).normal(size=(20, len(quantity.channels) or 9)))
        for i, (name, quantity) in enumerate(QUANTITIES.items())
    }
    write_mcap(Recording("mixed", "boom36", "", signals), tmp_path / "log.mcap")
    store = get_typestore(Stores.ROS2_JAZZY)
    with Ros2Reader(tmp_path / "log.mcap") as reader:
        assert {c.topic for c in reader.connections} == {f"/imu/link{i}" for i in range(2, 6)} | {
            "/joint_states", "/joint_command", "/markers", "/markers/truck", "/cylinder_states", "/load"
        }  # fmt: skip
        rows = [
            list(store.deserialize_cdr(data, connection.msgtype).position)
            for connection, _, data in reader.messages([c for c in reader.connections if c.topic == "/joint_states"])
        ]
    np.testing.assert_array_equal(rows, signals["joint/position"].values)


@pytest.fixture(scope="module")
def whole_logs(tmp_path_factory) -> list[tuple[str, bytes]]:
    paths = [writer(tmp_path_factory.mktemp("whole")) for writer in foreign.WRITERS if writer != foreign.from_ros2_bag]
    return [(path.name, path.read_bytes()) for path in paths]


@settings(max_examples=250, deadline=None)
@given(
    data=st.data(), which=st.integers(0, len(foreign.WRITERS) - 2), how=st.sampled_from(["cut", "flip", "fill", "swap"])
)
def test_broken_logs_end_in_clear_errors_only(data, which, how, whole_logs, tmp_path_factory):
    name, content = whole_logs[which]
    broken, place = bytearray(content), data.draw(st.integers(0, len(content) - 1))
    if how == "cut":
        del broken[place:]
    elif how == "flip":
        broken[place] ^= data.draw(st.integers(1, 255))
    elif how == "fill":
        broken[place : place + 8] = bytes([data.draw(st.sampled_from([0, 255]))]) * 8
    else:
        broken[place : place + 64] = reversed(broken[place : place + 64])
    path = tmp_path_factory.mktemp("broken") / name
    path.write_bytes(broken)
    columns = {
        "topic": "table",
        "field": "columns",
        "source": tuple(f"q{i}_rad" for i in range(1, 6)),
        "time": "time_s",
    }
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            assert read(path, angles_entry(**columns if ".csv" in name else {})).duration >= 0
        except LogError as error:
            assert name in str(error)
        try:
            propose_map(inspect_log(path))
        except LogError as error:
            assert name in str(error)
