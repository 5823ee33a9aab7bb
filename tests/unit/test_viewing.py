"""What a viewer opens: twin and log in one file, and the boom moving in 3D, read by another reader."""

from pathlib import Path

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory

from boom_mj.effects import make_effect
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


def place(transforms: list, frame: str) -> np.ndarray:
    tip = next(t for t in transforms if t.child_frame_id == frame).transform.translation
    return np.array([tip.x, tip.y, tip.z])


def test_the_frames_carry_the_tip_to_where_the_marker_is(written: tuple) -> None:
    motion, _, _, path = written
    last = messages(path, "/tf")[-1].transforms
    stamp = last[0].header.stamp
    when = np.searchsorted(motion.time, stamp.sec + 1e-9 * stamp.nanosec)
    assert place(last, "link5_tip") == pytest.approx(motion.sensor("marker12")[when], abs=1e-9)
    assert {t.header.frame_id for t in last} == {"world"}


def test_every_box_of_the_boom_hangs_on_its_frame(written: tuple) -> None:
    path = written[3]
    frames = {t.child_frame_id for t in messages(path, "/tf")[0].transforms}
    markers = {marker.header.frame_id: marker for marker in messages(path, "/scene")[0].markers}
    assert set(markers) == {f"link{i}_{piece}" for i in range(2, 6) for piece in range(1, 7)} <= frames
    root = np.array([(p.x, p.y, p.z) for p in markers["link2_1"].points])
    assert root[:, 0].min() == pytest.approx(-8.5, abs=1e-6)
    assert np.ptp(root[:, 1]) == pytest.approx(0.6, abs=1e-6)  # the section at the root is 0.60 m high
    corners = root.reshape(-1, 3, 3)  # triangles look outward
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert (np.einsum("ij,ij->i", normals, corners.mean(axis=1) - root.mean(axis=0)) > 0).all()


def test_every_frame_of_a_header_is_in_the_tree(written: tuple) -> None:
    """By two readers that are not ours."""
    path, found = written[3], set()
    with path.open("rb") as stream:
        for _, channel, _, message in make_reader(stream, decoder_factories=[DecoderFactory()]).iter_decoded_messages():
            if hasattr(message, "header") and channel.topic != "/tf":
                found.add(message.header.frame_id)
    tree = {t.child_frame_id for t in messages(path, "/tf")[0].transforms} | {"world"}
    assert found <= tree and {"link2_tip", "link5_tip", "base"} <= found


@pytest.mark.parametrize("hinges", [1, 2, 5])
def test_the_frames_are_the_same_for_any_number_of_hinges(hinges: int, written: tuple) -> None:
    motion = run_experiment(make_plant(MACHINE, hinges), CATALOGUE["slew_t"])
    scene, usual = boom_scene(motion), boom_scene(written[0])
    assert scene.frames == usual.frames
    assert all(np.array_equal(*pair) for pair in zip(scene.triangles, usual.triangles))
    tip = scene.frames.index("link5_tip")
    step = np.searchsorted(motion.time, scene.time[-1])
    np.testing.assert_allclose(scene.position[-1, tip], motion.sensor("marker12")[step], atol=1e-9)
    ends = [scene.position[0, scene.frames.index(f"link3_{k}")] for k in range(1, 7)]  # where the tip would be
    assert 2 <= len({tuple(np.round(end, 9)) for end in ends}) <= hinges + 1  # as many as bodies that carry a piece


def test_an_effect_adds_no_frame(written: tuple) -> None:
    plant = make_plant(MACHINE, 2, [make_effect("tip_payload", {"mass": 50.0})])
    assert boom_scene(run_experiment(plant, CATALOGUE["slew_t"])).frames == boom_scene(written[0]).frames


def test_fixed_frames_stay() -> None:
    motion = run_experiment(make_plant(MACHINE), CATALOGUE["slew_t"])
    scene = boom_scene(motion, 2.0, {"camera": (np.array([1.0, 2.0, 3.0]), np.array([0.0, 1.0, 0.0, 0.0]))})
    assert scene.frames[-1] == "camera" and scene.time[0] == 2.0
    assert (scene.position[:, -1] == [1, 2, 3]).all() and (scene.quaternion[:, -1] == [0, 1, 0, 0]).all()
