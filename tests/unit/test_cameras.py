"""Data sets as a user makes them: small pictures of the truck and the first link, killed, resumed, loaded, tracked."""

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import cv2
import numpy as np
import pytest
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from opengl import can_render
from small_rig import RIG, ROOT, SHORT, TEXT, boom

from boom_mj.cameras.chain import track
from boom_mj.cameras.dataset import DEPTH_UNIT
from boom_mj.cameras.intrinsics import Intrinsics
from boom_mj.cameras.yard import GROUND_REACH
from boom_mj.errors import DatasetError
from boom_mj.logs import read_mcap
from boom_mj.machine import load_machine

needs_egl = pytest.mark.skipif(not can_render(), reason="EGL cannot render here")


def files(folder: Path) -> dict[str, bytes]:
    return {str(p.relative_to(folder)): p.read_bytes() for p in sorted(folder.rglob("*")) if p.is_file()}


@pytest.fixture(scope="module")
def machine(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("machine") / "close.toml"
    path.write_text(TEXT + RIG)
    return path


@pytest.fixture(scope="module")
def made(machine: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("made") / "set"
    layouts = "coco,nerfstudio,bop,mcap"
    done = boom("render", machine, "-o", folder, *SHORT, "--masks", "--depth", "--layout", layouts)
    assert done.returncode == 0, done.stderr
    return folder


@needs_egl
def test_the_layouts_load_in_their_readers(made: Path) -> None:
    coco = pytest.importorskip("pycocotools.coco").COCO(made / "annotations.json")
    boom_id = coco.getCatIds(catNms=["boom"])
    for annotation in coco.loadAnns(coco.getAnnIds(catIds=boom_id)):
        assert len(annotation["keypoints"]) == 3 * 24 and annotation["num_keypoints"] > 0
    mask = {p.name: cv2.imread(str(p), cv2.IMREAD_UNCHANGED) for p in (made / "masks" / "right").iterdir()}
    picture = next(i for i in coco.loadImgs(coco.getImgIds()) if i["file_name"] == "images/right/000001.png")
    link = coco.loadAnns(coco.getAnnIds(imgIds=[picture["id"]], catIds=coco.getCatIds(catNms=["link2"])))[0]
    covered = coco.annToMask(link)
    assert covered.sum() == link["area"] and covered.shape == mask["000001.png"].shape

    transforms = json.loads((made / "transforms.json").read_text())
    assert transforms["camera_model"] == "OPENCV" and len(transforms["frames"]) == 6
    for frame in transforms["frames"]:
        pose = np.array(frame["transform_matrix"])
        assert pose.shape == (4, 4) and np.linalg.det(pose[:3, :3]) == pytest.approx(1)
        assert (made / frame["file_path"]).is_file() and (made / frame["depth_file_path"]).is_file()
        label = json.loads((made / frame["file_path"].replace("images", "labels").replace("png", "json")).read_text())
        seen = [plate for plate in label["plates"].values() if plate["visible"] > 0]
        centers = np.array([[*plate["center"], 1.0] for plate in seen])
        inside = (centers @ np.linalg.inv(pose).T)[:, :3] * [1, -1, -1]
        lens = [[frame["fl_x"], 0, frame["cx"]], [0, frame["fl_y"], frame["cy"]], [0, 0, 1]]
        brown = np.array([frame[name] for name in ("k1", "k2", "p1", "p2", "k3")])
        pixels = cv2.projectPoints(inside, np.zeros(3), np.zeros(3), np.array(lens), brown)[0][:, 0]
        ours = np.array([plate["pixel"] for plate in seen])
        assert np.abs(pixels - ours - 0.5).max() < 1e-3  # px; counted from the corner there

    bop = made / "bop"
    info = json.loads((bop / "models" / "models_info.json").read_text())
    truth = json.loads((bop / "test" / "000001" / "scene_gt.json").read_text())
    seen = json.loads((bop / "test" / "000001" / "scene_gt_info.json").read_text())
    camera = json.loads((bop / "test" / "000001" / "scene_camera.json").read_text())
    assert set(truth) == set(seen) == set(camera) == {"0", "1", "2"} and len(truth["0"]) == len(info) == 8
    assert (bop / "test" / "000001" / "rgb" / "000000.png").is_file()
    assert 0 < seen["0"][0]["visib_fract"] <= 1.05  # outline and mask differ along the rim
    assert "distortion" not in camera["0"]

    with (made / "dataset.mcap").open("rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        messages = {}
        for _, channel, _, message in reader.iter_decoded_messages():
            messages.setdefault(channel.topic, []).append(message)
    assert len(messages["/camera/1/image/compressed"]) == len(messages["/camera/2/camera_info"]) == 3
    decoded = cv2.imdecode(np.frombuffer(messages["/camera/1/image/compressed"][0].data, np.uint8), cv2.IMREAD_COLOR)
    assert decoded.shape == (288, 448, 3) and messages["/camera/1/camera_info"][0].distortion_model == "plumb_bob"
    assert {"/joint_states", "/markers", "/imu/link5"} <= set(messages)
    frames = {t.child_frame_id: t.transform for t in messages["/tf"][0].transforms}
    assert {"left", "right", "link2_tip", "link5_tip"} <= set(frames)
    assert {m.header.frame_id for m in messages["/camera/1/image/compressed"]} <= set(frames)
    assert frames["right"].translation.z == pytest.approx(2.5)


@needs_egl
def test_labels_say_what_the_pictures_show(made: Path) -> None:
    label = json.loads((made / "labels" / "left" / "000000.json").read_text())
    depth = cv2.imread(str(made / "depth" / "left" / "000000.png"), cv2.IMREAD_UNCHANGED)
    masks = cv2.imread(str(made / "masks" / "left" / "000000.png"), cv2.IMREAD_UNCHANGED)
    pose, seen = np.array(label["camera_from_world"]), 0
    for name, plate in label["plates"].items():
        if plate["visible"] < 1:
            continue
        u, v = np.round(plate["pixel"]).astype(int)
        inside = pose[:3, :3] @ plate["center"] + pose[:3, 3]
        assert depth[v, u] * DEPTH_UNIT == pytest.approx(inside[2], abs=0.06)  # m: half a pixel of a tilted plate
        assert (masks[v, u] > 0) == name.startswith("marker")
        seen += 1
    assert seen > 6
    assert label["plates"]["marker1_right"]["visible"] == 0  # the other side of the boom


@needs_egl
def test_depth_is_there_wherever_there_is_a_surface(made: Path) -> None:
    """Rays that hit the ground before it ends; the sky is without."""
    for camera in ("left", "right"):
        label = json.loads((made / "labels" / camera / "000000.json").read_text())
        depth = cv2.imread(str(made / "depth" / camera / "000000.png"), cv2.IMREAD_UNCHANGED)
        height, width = depth.shape
        lens = np.array(label["K"])
        intrinsics = Intrinsics(width, height, (lens[0, 0], lens[1, 1]), (lens[0, 2], lens[1, 2]), label["distortion"])
        grid = np.stack(np.meshgrid(np.arange(width), np.arange(height)), axis=-1)
        pose = np.array(label["camera_from_world"])
        rays = np.concatenate([intrinsics.rays(grid), np.ones((height, width, 1))], axis=-1) @ pose[:3, :3]
        place = -pose[:3, :3].T @ pose[:3, 3]
        down = np.where(rays[..., 2] < 0, -place[2] / rays[..., 2], np.inf)
        hit = place[:2] + down[..., None] * rays[..., :2]
        edge = GROUND_REACH * sum(link.length for link in load_machine("boom36").links)
        ground = (down < np.inf) & (np.abs(np.nan_to_num(hit, posinf=1e9, neginf=-1e9)) < edge).all(axis=-1)
        ground = cv2.erode(ground.astype(np.uint8), np.ones((3, 3), np.uint8)) > 0  # its edge falls between pixels
        assert ground.any() and (depth[ground] > 0).all()
        assert (depth[0] == 0).any()  # there is sky


@needs_egl
def test_pictures_and_labels_of_bop_have_one_pinhole_model(made: Path) -> None:
    for scene in sorted((made / "bop" / "test").iterdir()):
        cameras, infos = (json.loads((scene / f"scene_{part}.json").read_text()) for part in ("camera", "gt_info"))
        lens = np.array(cameras["0"]["cam_K"]).reshape(3, 3)
        compared = 0
        for k, info in enumerate(infos["0"]):
            mask, visible = (
                cv2.imread(str(scene / kind / f"000000_{k:06d}.png"), cv2.IMREAD_UNCHANGED) > 0
                for kind in ("mask", "mask_visib")
            )
            if info["visib_fract"] < 0.9 or mask.sum() < 300:
                continue
            rim = cv2.morphologyEx(mask.astype(np.uint8), cv2.MORPH_GRADIENT, np.ones((3, 3), np.uint8))
            assert (mask ^ visible).sum() < 0.5 * rim.sum(), (scene.name, k)  # they differ along the rim alone
            compared += 1
        assert compared
        depth = cv2.imread(str(scene / "depth" / "000000.png"), cv2.IMREAD_UNCHANGED) * cameras["0"]["depth_scale"]
        turn = np.array(cameras["0"]["cam_R_w2c"]).reshape(3, 3)
        shift, near = np.array(cameras["0"]["cam_t_w2c"]), 0
        for label in (json.loads(p.read_text()) for p in (made / "labels").rglob("000000.json")):
            if not np.allclose(np.array(label["camera_from_world"])[:3, :3], turn, atol=1e-6):
                continue
            for plate in label["plates"].values():
                inside = turn @ plate["center"] * 1000 + shift
                pixel = lens @ inside / inside[2]
                u, v = np.round(pixel[:2]).astype(int)
                if plate["visible"] == 1 and 0 <= u < depth.shape[1] and 0 <= v < depth.shape[0]:
                    assert depth[v, u] == pytest.approx(inside[2], abs=120)  # mm: a pixel of a tilted plate
                    near += 1
        assert near > 3


@needs_egl
def test_killed_and_started_again_gives_the_same_bytes(machine: Path, made: Path, tmp_path: Path) -> None:
    folder = tmp_path / "killed"
    layouts = ("--masks", "--depth", "--layout", "coco,nerfstudio,bop,mcap")
    call = [sys.executable, "-m", "boom_mj", "render", machine, "-o", folder, *SHORT, *layouts]
    process = subprocess.Popen(
        [*map(str, call)], cwd=ROOT, env={**os.environ, "MUJOCO_GL": "egl"}, stderr=-3, stdout=-3
    )
    while process.poll() is None and not list(folder.glob("labels/*/*.json")):
        time.sleep(0.02)
    process.send_signal(signal.SIGKILL)
    process.wait()
    time.sleep(0.5)  # its workers leave by themselves
    assert not (folder / "annotations.json").exists()
    done = boom("render", machine, "-o", folder, "--start", 8.0, "--stop", 8.1, "--workers", 1, *layouts)
    assert done.returncode == 0, done.stderr
    whole, resumed = files(made), files(folder)
    assert set(whole) == set(resumed)
    assert [name for name in whole if whole[name] != resumed[name]] == []

    other = boom("render", machine, "-o", folder, "--start", 8.0, "--stop", 8.2)
    assert other.returncode == 2 and "another data set" in other.stderr and "stop" in other.stderr


@needs_egl
def test_a_cluster_makes_the_same_bytes(machine: Path, made: Path, tmp_path: Path) -> None:
    distributed = pytest.importorskip("distributed")
    options = {"threads_per_worker": 1, "dashboard_address": None, "host": "127.0.0.1", "env": {"MUJOCO_GL": "egl"}}
    layouts = ("--masks", "--depth", "--layout", "coco,nerfstudio,bop,mcap")
    with distributed.LocalCluster(n_workers=1, **options, local_directory=str(tmp_path / "dask")) as cluster:
        done = boom("render", machine, "-o", tmp_path / "set", *SHORT, *layouts, "--cluster", cluster.scheduler_address)
    assert done.returncode == 0, done.stderr
    assert files(tmp_path / "set") == files(made)


@needs_egl
def test_track_finds_the_markers_that_both_sides_show(made: Path, tmp_path: Path) -> None:
    output, video, anyones = tmp_path / "markers.mcap", tmp_path / "left.webm", tmp_path / "set"
    shutil.copytree(made, anyones, ignore=shutil.ignore_patterns("labels", "depth", "masks", "bop", "*.mcap"))
    done = boom("track", anyones, "-o", output, "--overlay", tmp_path / "o.png", "--video", video, "--json")
    assert done.returncode == 0, done.stderr
    document = json.loads(done.stdout)
    shares = [marker["share"] for marker in document["markers"]]
    assert shares[:2] == [1.0, 1.0] and set(shares[6:]) == {0.0}
    assert document["cameras"]["right"]["focal_px"][0] == pytest.approx(390, rel=0.002)
    truth = [json.loads((made / "labels" / "right" / f"{k:06d}.json").read_text())["markers"] for k in range(3)]
    found = read_mcap(output)["markers"].values.reshape(3, 12, 3)
    error = found[:, :2] - np.array(truth)[:, :2]
    assert np.abs(error).max() < 0.01  # m: 30 mm per pixel, some hundredths of a pixel
    assert np.isnan(found[:, 6:]).all()
    assert video.read_bytes().startswith(b"\x1aE\xdf\xa3") and (tmp_path / "o.png").stat().st_size > 1000


@needs_egl
def test_a_log_in_any_weather_depends_on_the_frame_alone(machine: Path, made: Path, tmp_path: Path) -> None:
    options = ["--start", 9.0, "--stop", 9.2, "--seed", 7, "--noise", "--blur", 2, "--rolling", 2, "--jpeg", 90]
    options += ["--randomise", "light,texture,pose", "--no-calibration", "--scale", 0.5, "--camera", "left"]
    folder = tmp_path / "set"
    log = made / "dataset.mcap", "--machine", machine
    done = boom("render", *log, "-o", folder, *options, "--workers", 2)
    assert done.returncode == 0, done.stderr
    whole = files(folder)
    for path in (*folder.glob("*/left/*3.*"), folder / "annotations.json"):
        path.unlink()
    done = boom("render", *log, "-o", folder, *options, "--workers", 1)
    assert done.returncode == 0, done.stderr
    assert files(folder) == whole
    light = [cv2.imread(str(folder / "images" / "left" / f"{k:06d}.jpg")).mean() for k in range(5)]
    assert max(light) - min(light) > 1
    with pytest.raises(DatasetError, match="stand still"):
        track(folder)
