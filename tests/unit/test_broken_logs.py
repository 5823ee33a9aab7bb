"""Our logs in other readers, and broken ones in ours."""

import warnings

import foreign
import numpy as np
import pytest
from foreign import angles_entry, read
from hypothesis import given, settings
from hypothesis import strategies as st
from rosbags.rosbag2 import Reader as Ros2Reader
from rosbags.typesys import Stores, get_typestore

from boom_mj.errors import LogError
from boom_mj.logs import write_mcap
from boom_mj.logs.inspection import inspect_log
from boom_mj.logs.proposal import propose_map
from boom_mj.recording import QUANTITIES, Recording, named_signal


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
