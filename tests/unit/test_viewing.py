"""What a viewer opens: twin and log in one file, and the boom moving in 3D, read by another reader."""

from pathlib import Path

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory

from boom_mj.logs import read_mcap, write_mcap
from boom_mj.machine import load_machine
from boom_mj.sensors import boom_scene, measure
from boom_mj.simulation import CATALOGUE, make_plant, run_experiment

MACHINE = load_machine(Path(__file__).parents[2] / "models" / "boom36.toml")


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> tuple:
    motion = run_experiment(make_plant(MACHINE), CATALOGUE["slew_t"])
    twin = measure(motion, "slew_t", "ideal", 30.0)
    log = measure(motion, "slew_t", "noisy", 30.0, np.random.default_rng(1))
    path = tmp_path_factory.mktemp("view") / "twin.mcap"
    write_mcap(twin, path, beside={"/measured": log}, scene=boom_scene(motion))
    return motion, twin, log, path


def messages(path: Path, topic: str) -> list:
    with path.open("rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        return [message for _, _, _, message in reader.iter_decoded_messages(topics=[topic])]


def test_twin_and_log_lie_side_by_side(written: tuple) -> None:
    _, twin, log, path = written
    assert np.array_equal(read_mcap(path)["markers"].values, twin["markers"].values)
    measured = messages(path, "/measured/cylinder_states")
    assert [message.effort[0] for message in measured] == log["cylinder/force"].values[:, 0].tolist()


def test_the_frames_carry_the_tip_to_where_the_marker_is(written: tuple) -> None:
    motion, _, _, path = written
    last = messages(path, "/tf")[-1]
    tip = next(t for t in last.transforms if t.child_frame_id == "link5_2").transform.translation
    when = np.searchsorted(
        motion.time, last.transforms[0].header.stamp.sec + 1e-9 * last.transforms[0].header.stamp.nanosec
    )
    assert (tip.x, tip.y, tip.z) == pytest.approx(motion.sensor("marker12")[when], abs=1e-9)


def test_every_box_of_the_boom_hangs_on_its_frame(written: tuple) -> None:
    path = written[3]
    frames = {t.child_frame_id for t in messages(path, "/tf")[0].transforms}
    markers = messages(path, "/scene")[0].markers
    assert {marker.header.frame_id for marker in markers} <= frames
    assert len(markers) == 8  # two bodies a link
    root = np.array([(p.x, p.y, p.z) for p in next(m for m in markers if m.header.frame_id == "link2").points])
    assert root[:, 0].min() == pytest.approx(-8.5, abs=1e-6)
    assert np.ptp(root[:, 1]) == pytest.approx(0.6, abs=1e-6)  # the section at the root is 0.60 m high
