"""Logs from elsewhere: the same angles come out of every format; what is wrong is handled aloud or refused by name."""

import warnings

import foreign
import numpy as np
import pytest
from foreign import ANGLES, TIME, joint_states, proposed, ros2, write_mcap_channels
from mcap.writer import CompressionType

from boom_mj.errors import LogError, LogWarning
from boom_mj.logs import read_log


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
