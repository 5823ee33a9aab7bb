"""Faults of logs are handled aloud, or refused by file, topic, joint and time."""

import gzip
import os

import numpy as np
import pytest
from foreign import (
    ANGLES,
    JOINTS,
    START,
    TIME,
    angles_entry,
    imu,
    joint_state,
    joint_states,
    log_of,
    read,
    ros2,
    write_mcap_channels,
)

from boom_mj.errors import LogError, LogWarning
from boom_mj.logs import read_log, write_mcap
from boom_mj.logs.inspection import inspect_log
from boom_mj.logs.topic_map import Entry


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


def test_zeros_behind_a_gzipped_table_are_no_end_without_end(tmp_path):
    path = tmp_path / "log.csv.gz"
    path.write_bytes(gzip.compress(b"t,a\n0,1\n"))
    os.truncate(path, 2**34)
    with pytest.raises(LogError, match="damaged: it ends in zeros"):
        inspect_log(path)
    os.truncate(path, 0)
    with pytest.raises(LogError, match="is empty"):
        inspect_log(path)


def test_a_table_of_very_many_columns_is_inspected_without_them(tmp_path):
    (tmp_path / "log.csv").write_text(",".join(f"c{k}" for k in range(20_000)) + "\n" + "0," * 19_999 + "0\n")
    (topic,) = inspect_log(tmp_path / "log.csv").topics
    assert (topic.count, topic.fields) == (1, {})
