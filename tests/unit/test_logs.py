"""Logs: what is written is read back, by this reader and by a foreign one; what is broken is refused by name."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mcap.reader import make_reader
from mcap.writer import Writer
from mcap_ros2.decoder import DecoderFactory

from boom_mj.errors import LogError, LogWarning, OutputError
from boom_mj.logs import read_mcap, write_mcap
from boom_mj.logs.container import Container
from boom_mj.logs.messages import make, typestore
from boom_mj.recording import QUANTITIES, Recording, named_signal

EXAMPLES = Path(__file__).parents[2].parent / "shared" / "examples"
SHARED_TIME = {"imu/": 50.0, "joint_command": 20.0, "cylinder": 25.0}  # Hz; signals of one message


def recording(seed: int = 0, names: tuple[str, ...] = tuple(QUANTITIES), duration: float = 1.0) -> Recording:
    """Random values under the given names, a fifth of the markers hidden."""
    rng = np.random.default_rng(seed)
    signals = {}
    for name in names:
        rate = next((hz for start, hz in SHARED_TIME.items() if name.startswith(start)), 40.0)
        time = np.round(np.arange(round(duration * rate) + 1) / rate * 1e9) / 1e9  # whole nanoseconds
        values = rng.normal(size=(time.size, len(QUANTITIES[name].channels) or 9))
        if name.startswith("markers"):
            hidden = np.repeat(rng.random((time.size, values.shape[1] // 3)) < 0.2, 3, axis=1)
            values[hidden] = np.nan
        signals[name] = named_signal(name, time, values)
    return Recording("mixed", "boom36", "a description", signals)


def assert_same(found: Recording, expected: Recording) -> None:
    assert (found.name, found.machine, found.description) == (expected.name, expected.machine, expected.description)
    assert set(found.signals) == set(expected.signals)
    for name, signal in expected.signals.items():
        np.testing.assert_array_equal(found[name].time, signal.time)
        np.testing.assert_array_equal(found[name].values, signal.values)
        assert (found[name].channels, found[name].unit) == (signal.channels, signal.unit)
        assert found[name].frame == signal.frame


@settings(max_examples=15, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), names=st.sets(st.sampled_from(sorted(QUANTITIES)), min_size=1))
def test_whatever_is_written_is_read_back_to_the_bit(seed, names, tmp_path_factory):
    path = tmp_path_factory.mktemp("logs") / "log.mcap"
    written = recording(seed, tuple(sorted(names)), duration=0.2)
    write_mcap(written, path)
    assert_same(read_mcap(path), written)


def test_no_time_is_off_by_a_nanosecond(tmp_path):
    time = np.arange(5000) / 1000  # 1.001 * 1e9 is 1000999999.9999999
    written = Recording("r", "m", "", {"load": named_signal("load", time, np.zeros((5000, 3)))})
    write_mcap(written, tmp_path / "log.mcap")
    np.testing.assert_array_equal(read_mcap(tmp_path / "log.mcap")["load"].time, time)


def test_equal_recordings_give_equal_bytes(tmp_path):
    a, b, c = (tmp_path / name for name in ("a.mcap", "b.mcap", "c.mcap"))
    write_mcap(recording(), a)
    write_mcap(read_mcap(a), b)
    write_mcap(recording(seed=1), c)
    assert a.read_bytes() == b.read_bytes() != c.read_bytes()


def test_a_foreign_reader_finds_the_same_numbers(tmp_path):
    written = recording()
    write_mcap(written, tmp_path / "log.mcap", variance={"imu/link3/angular_rate": 1e-6})
    found: dict[str, list] = {}
    with (tmp_path / "log.mcap").open("rb") as stream:
        for _, channel, message, decoded in make_reader(stream, True, [DecoderFactory()]).iter_decoded_messages():
            stamp = decoded.header.stamp
            assert message.log_time == message.publish_time == stamp.sec * 10**9 + stamp.nanosec
            found.setdefault(channel.topic, []).append((message.log_time / 1e9, decoded))

    def compare(topic, name, frame_id, row):
        times, messages = zip(*found[topic], strict=True)
        np.testing.assert_array_equal(times, written[name].time)
        np.testing.assert_array_equal([row(m) for m in messages], written[name].values)
        assert {m.header.frame_id for m in messages} == {frame_id}

    def xyz(vector):
        return vector.x, vector.y, vector.z

    def points(message):
        return [x for pose in message.poses for x in xyz(pose.position)]

    compare("/joint_states", "joint/position", "base", lambda m: m.position)
    compare("/joint_command", "joint_command/position", "base", lambda m: m.position)
    compare("/joint_command", "joint_command/velocity", "base", lambda m: m.velocity)
    for link in ("link2", "link3", "link4", "link5"):
        frame = f"{link}_tip"
        compare(f"/imu/{link}", f"imu/{link}/specific_force", frame, lambda m: xyz(m.linear_acceleration))
        compare(f"/imu/{link}", f"imu/{link}/angular_rate", frame, lambda m: xyz(m.angular_velocity))
    compare("/markers", "markers", "world", points)
    compare("/markers/truck", "markers/truck", "world", points)
    compare("/cylinder_states", "cylinder/force", "base", lambda m: m.effort)
    compare("/cylinder_states", "cylinder/length", "base", lambda m: m.position)
    compare("/load", "load", "world", lambda m: xyz(m.wrench.force))
    assert found["/joint_states"][0][1].name == ["joint1", "joint2", "joint3", "joint4", "joint5"]
    assert found["/cylinder_states"][0][1].name == ["cylinder2", "cylinder3"]
    imu = found["/imu/link3"][0][1]
    assert imu.orientation_covariance[0] == -1
    assert list(imu.angular_velocity_covariance) == [1e-6, 0, 0, 0, 1e-6, 0, 0, 0, 1e-6]
    assert not any(imu.linear_acceleration_covariance)


def test_a_failing_write_leaves_the_old_file_and_nothing_else(tmp_path, monkeypatch):
    path = tmp_path / "log.mcap"
    write_mcap(recording(), path)
    before = path.read_bytes()

    def full(*args, **kwargs):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Container, "finish", full)
    with pytest.raises(OutputError, match=r"log\.mcap cannot be written: No space left"):
        write_mcap(recording(seed=1), path)
    assert path.read_bytes() == before
    assert list(tmp_path.iterdir()) == [path]


def test_a_folder_that_is_not_there_is_named(tmp_path):
    with pytest.raises(OutputError, match=r"nowhere.log\.mcap cannot be written"):
        write_mcap(recording(), tmp_path / "nowhere" / "log.mcap")


def test_what_a_log_cannot_hold_is_refused_before_a_file_appears(tmp_path):
    path, good = tmp_path / "log.mcap", recording()
    angles = good["joint/position"]
    rate = good["imu/link2/angular_rate"]
    nan = angles.values.copy()
    nan[4, 2] = np.nan
    cases = {
        "no topic carries residual": {"residual": angles},
        r"joint3 of 'joint/position' is NaN at 0\.100 s": {
            "joint/position": named_signal("joint/position", angles.time, nan)
        },
        "share the messages of /imu/link2 but not their times": {
            "imu/link2/angular_rate": named_signal("imu/link2/angular_rate", rate.time + 0.001, rate.values)
        },
        r"from -1\.000": {"joint/position": named_signal("joint/position", angles.time - 1, angles.values)},
        "two samples in one nanosecond": {
            "joint/position": named_signal("joint/position", angles.time * 1e-9, angles.values)
        },
    }
    for says, change in cases.items():
        with pytest.raises(LogError, match=says):
            write_mcap(good.with_signals(change), path)
    with pytest.raises(LogError, match="no signals to write"):
        write_mcap(Recording("empty", "boom36", "", {}), path)
    with pytest.raises(LogError, match="no topic carries imu/link9"):
        write_mcap(good, path, variance={"imu/link9": 1.0})
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("part", [0.0, 0.00005, 0.001])
def test_a_file_cut_off_before_its_first_message_is_refused(part, tmp_path):
    path = tmp_path / "log.mcap"
    write_mcap(recording(), path)
    whole = path.read_bytes()
    path.write_bytes(whole[: int(part * len(whole))])
    with pytest.raises(LogError, match=r"log\.mcap is (empty|cut off|not an MCAP file)"):
        read_mcap(path)


@pytest.mark.parametrize("part", [0.1, 0.5, 0.9, 0.99, 0.999999])
def test_a_file_cut_off_is_read_up_to_the_cut_and_says_what_is_lost(part, tmp_path):
    path = tmp_path / "log.mcap"
    write_mcap(recording(duration=20.0), path)
    whole, complete = path.read_bytes(), read_mcap(path)
    path.write_bytes(whole[: int(part * len(whole))])
    with pytest.warns(LogWarning, match=r"log\.mcap is cut off.* lost"):
        found = read_mcap(path)
    assert found.machine == "boom36"
    assert part - 0.3 < found.duration / 20 <= 1  # the compressor holds back less than its window
    for name, signal in found.signals.items():
        np.testing.assert_array_equal(signal.values, complete[name].values[: len(signal.time)])
        np.testing.assert_array_equal(signal.time, complete[name].time[: len(signal.time)])
    if part > 0.99:
        assert_same(found, complete)


def test_flipped_bytes_are_refused_or_do_not_reach_the_numbers(tmp_path):
    path = tmp_path / "log.mcap"
    write_mcap(recording(), path)
    whole, refused = path.read_bytes(), 0
    for place in np.linspace(0, len(whole) - 1, 60).astype(int):
        path.write_bytes(whole[:place] + bytes([whole[place] ^ 0xFF]) + whole[place + 1 :])
        try:
            found = read_mcap(path)
        except LogError as error:
            assert "log.mcap" in str(error)
            refused += 1
        else:
            for name, signal in recording().signals.items():
                if name in found:
                    np.testing.assert_array_equal(found[name].values, signal.values)
    assert refused > 40


@pytest.mark.parametrize(("content", "says"), [(b"", "is empty"), (b"time,joint1\n0,1\n" * 99, "not an MCAP file")])
def test_what_is_not_a_log_is_called_so(content, says, tmp_path):
    (tmp_path / "garbage.mcap").write_bytes(content)
    with pytest.raises(LogError, match=rf"garbage\.mcap {says}|garbage\.mcap is {says}"):
        read_mcap(tmp_path / "garbage.mcap")
    with pytest.raises(LogError, match=r"missing\.mcap cannot be read"):
        read_mcap(tmp_path / "missing.mcap")


def test_a_log_without_joint_angles_says_so_when_they_are_asked_for(tmp_path):
    write_mcap(recording(names=("load", "markers")), tmp_path / "log.mcap")
    found = read_mcap(tmp_path / "log.mcap")
    with pytest.raises(LogError, match="'mixed' has no signal 'joint/position'; it has markers, load"):
        found["joint/position"]


def header(seconds: float, frame_id: str = "base"):
    stamp = make("builtin_interfaces/msg/Time", *divmod(round(seconds * 1e9), 10**9))
    return make("std_msgs/msg/Header", stamp=stamp, frame_id=frame_id)


def joint_state(seconds: float, names: list[str], position: list[float], velocity: tuple[float, ...] = ()):
    arrays = (np.array(position, float), np.array(velocity, float), np.empty(0))
    return make("sensor_msgs/msg/JointState", header(seconds), names, *arrays)


def foreign_log(path: Path, topic: str, messages: list, **writer) -> Path:
    """A log as another program might write it: one topic, messages as they are, no metadata."""
    ros_type = messages[0].__msgtype__ if messages else "sensor_msgs/msg/JointState"
    with path.open("wb") as stream:
        log = Writer(stream, **writer)
        log.start("ros2", "foreign")
        definition, _ = typestore().generate_msgdef(ros_type, ros_version=2)
        channel = log.register_channel(topic, "cdr", log.register_schema(ros_type, "ros2msg", definition.encode()))
        for i, message in enumerate(messages):
            log.add_message(channel, i, bytes(typestore().serialize_cdr(message, ros_type)), i)
        log.finish()
    return path


JOINTS = ["joint1", "joint2", "joint3", "joint4", "joint5"]


@pytest.mark.parametrize("writer", [{}, {"use_chunking": False}])
def test_permuted_joints_are_put_right_by_name_even_if_the_order_changes(writer, tmp_path):
    first = joint_state(0.5, ["joint5", "pump", "joint1", "joint3", "joint2", "joint4"], [5, 9, 1, 3, 2, 4])
    second = joint_state(0.6, JOINTS, [1, 2, 3, 4, 5])
    found = read_mcap(foreign_log(tmp_path / "log.mcap", "/joint_states", [first, second], **writer))
    np.testing.assert_array_equal(found["joint/position"].values, [[1, 2, 3, 4, 5]] * 2)
    np.testing.assert_array_equal(found["joint/position"].time, [0.5, 0.6])
    assert (found.name, found.machine) == ("log", "")


def imu(seconds: float, frame_id: str):
    vector = make("geometry_msgs/msg/Vector3", 1.0, 2.0, 3.0)
    upright = make("geometry_msgs/msg/Quaternion", 0.0, 0.0, 0.0, 1.0)
    zeros = np.zeros(9)
    return make("sensor_msgs/msg/Imu", header(seconds, frame_id), upright, zeros, vector, zeros, vector, zeros)


def poses(seconds: float, count: int):
    point = make("geometry_msgs/msg/Point", 1.0, 2.0, 3.0)
    pose = make("geometry_msgs/msg/Pose", point, make("geometry_msgs/msg/Quaternion", 0.0, 0.0, 0.0, 1.0))
    return make("geometry_msgs/msg/PoseArray", header(seconds, "world"), [pose] * count)


@pytest.mark.parametrize(
    ("topic", "messages", "says"),
    [
        (
            "/joint_states",
            [joint_state(1.0, JOINTS[:4], [1, 2, 3, 4])],
            "joint5 missing; present are joint1, joint2, joint3, joint4",
        ),
        ("/joint_states", [joint_state(1.0, [*JOINTS, "joint2"], [1] * 6)], "joint2 missing or double"),
        ("/joint_states", [joint_state(1.0, JOINTS, [1, 2, 3, 4])], "4 values of position for the 5 names"),
        (
            "/joint_states",
            [joint_state(1.0, JOINTS, [1] * 5), joint_state(1.5, JOINTS, [])],
            r"position changes from 5 to 0 values at 1\.500 s",
        ),
        ("/joint_states", [joint_state(t, JOINTS, [x] * 5) for t, x in ((1, 1), (2, 2), (2, 3))], "2.0+ s with other"),
        ("/joint_states", [joint_state(t, JOINTS, [1] * 5) for t in (1.0, 3.0, 2.0)], "3.0+ s is followed by 2.0+ s"),
        ("/joint_states", [joint_state(1.0, JOINTS, [1, 2, np.nan, 4, 5])], r"joint3 .*NaN at 1\.000 s"),
        ("/joint_states", [imu(1.0, "base")], "messages are sensor_msgs/msg/Imu in cdr; must be sensor_msgs/msg/Joint"),
        ("/imu/link2", [imu(1.0, "link3_tip")], "frame_id is 'link3_tip'; must be 'link2_tip'"),
        ("/markers", [poses(1.0, 12), poses(2.0, 11)], r"11 poses instead of 12 at 2\.000 s"),
        ("/markers/truck", [poses(1.0, 4), poses(2.0, 3)], r"poses.* changes from 12 to 9 values at 2\.000 s"),
    ],
)
def test_what_is_wrong_in_a_log_is_refused_with_file_topic_and_cause(topic, messages, says, tmp_path):
    path = foreign_log(tmp_path / "log.mcap", topic, messages)
    with pytest.raises(LogError, match=rf"log\.mcap, topic {topic}: .*{says}"):
        read_mcap(path)


def test_a_log_of_other_things_only_is_refused_with_the_topics_that_count(tmp_path):
    for topic, messages in (("/joint_states", []), ("/elsewhere", [joint_state(0.0, JOINTS, [1] * 5)])):
        with pytest.raises(LogError, match="no messages on any of the topics /joint_states, /joint_command"):
            read_mcap(foreign_log(tmp_path / "log.mcap", topic, messages))


@pytest.mark.skipif(not EXAMPLES.is_dir(), reason="the example logs of an independent machine are not at hand")
def test_a_log_of_an_independent_machine_is_read_whole(tmp_path):
    path = sorted(EXAMPLES.glob("*/train/release_stretched_vertical.mcap"))[0]
    found = read_mcap(path)
    assert (found.name, found.machine) == ("release_stretched_vertical", "boom36")
    assert set(found.signals) == set(QUANTITIES) - {"markers/truck", "cylinder/length"}
    assert found.duration == 30.0
    assert (found["joint/position"].rate_hz, found["markers"].rate_hz) == pytest.approx((50, 20))
    np.testing.assert_array_equal(found["load"].values[0], [0, 0, -981])
    write_mcap(found, tmp_path / "copy.mcap")
    assert_same(read_mcap(tmp_path / "copy.mcap"), found)
