"""Our camera model against MuJoCo's camprojection and OpenCV's projectPoints; triangulation against planted points."""

from pathlib import Path

import cv2
import numpy as np
import pytest

from boom_mj.cameras.agreement import mujoco_projection
from boom_mj.cameras.backproject import back_project, right_hand
from boom_mj.cameras.calibrate import PlacedCamera
from boom_mj.cameras.intrinsics import Intrinsics
from boom_mj.cameras.lens import Lens
from boom_mj.cameras.rig import rig_of
from boom_mj.cameras.view import View, look_at
from boom_mj.machine import load_machine

MACHINE = load_machine(Path(__file__).parents[2] / "models" / "boom36.toml")
RIG = rig_of(MACHINE)
BROWN = (-0.11, 0.03, 4e-4, -3e-4, 0.002)


def points_before(view: View, count: int, seed: int) -> np.ndarray:
    """World points all over the picture, 2 to 60 m away."""
    rng = np.random.default_rng(seed)
    lens = view.intrinsics
    pixels = rng.uniform(0, [lens.width - 1, lens.height - 1], (count, 2))
    inside = np.column_stack([(pixels - lens.center) / lens.focal, np.ones(count)]) * rng.uniform(2, 60, (count, 1))
    return inside @ view.rotation + view.position


@pytest.mark.parametrize("camera", RIG, ids=lambda camera: camera.name)
def test_projection_is_opencvs(camera) -> None:
    lens = Intrinsics(1920, 1080, (1310.0, 1290.0), (940.5, 551.25), BROWN)
    view = View(lens, camera.view.rotation, camera.view.position)
    points = points_before(view, 500, 1)
    turn = cv2.Rodrigues(view.rotation)[0]
    theirs = cv2.projectPoints(points, turn, view.translation, lens.matrix, np.array(BROWN))[0][:, 0]
    assert np.abs(view.project(points) - theirs).max() < 1e-8  # both are float64 of the same formula


@pytest.mark.parametrize("camera", RIG, ids=lambda camera: camera.name)
def test_projection_is_mujocos(camera) -> None:
    # camprojection ignores principal points and counts from the picture's corner: centred lens, half a pixel apart
    lens = Intrinsics(1920, 1080, camera.view.intrinsics.focal, ((1920 - 1) / 2, (1080 - 1) / 2))
    view = View(lens, camera.view.rotation, camera.view.position)
    points = points_before(view, 50, 2)
    theirs = mujoco_projection(view, points)
    assert np.abs(view.project(points) - theirs).max() < 0.01  # MuJoCo keeps camera intrinsics in float32


def test_what_lies_behind_is_not_seen() -> None:
    view = RIG[0].view
    behind = view.position - 5 * view.rotation[2]
    assert np.isnan(view.project(behind)).all()
    assert not view.intrinsics.contains(view.project(behind))


def test_far_off_the_axis_nothing_folds_back_into_the_picture() -> None:
    lens = Intrinsics(640, 480, (400.0, 400.0), (320.0, 240.0), (-0.3, 0.0, 0.0, 0.0, 0.0))
    assert np.isnan(lens.pixels(np.array([2.0, 0.0, 1.0]))).all()  # r = 2 > 1 / sqrt(0.9)
    assert np.isfinite(lens.pixels(np.array([0.9, 0.0, 1.0]))).all()


def test_rays_undo_pixels() -> None:
    lens = RIG[1].view.intrinsics
    grid = np.stack(np.meshgrid(np.linspace(0, lens.width - 1, 9), np.linspace(0, lens.height - 1, 7)), axis=-1)
    rays = lens.rays(grid)
    back = lens.pixels(np.concatenate([rays, np.ones((*rays.shape[:2], 1))], axis=-1))
    assert np.abs(back - grid).max() < 1e-5  # px: 1e-9 of the fixed point times the focal length


def test_a_lens_shows_a_picture_of_its_pinhole_where_it_says() -> None:
    lens = Intrinsics(320, 200, (230.0, 230.0), (163.0, 97.0), (-0.2, 0.05, 1e-3, -1e-3, 0.0))
    source = Lens(lens).source
    spot = np.array([[0.31, -0.22, 1.0], [-0.5, 0.3, 1.0], [0.0, 0.0, 1.0]])
    rows, columns = np.mgrid[: source.height, : source.width]
    for point in spot:
        u, v = source.pixels(point)
        blob = 255 * np.exp(-((columns - u) ** 2 + (rows - v) ** 2) / 18)
        picture = Lens(lens).picture(np.repeat(blob[..., None].astype(np.float32), 3, axis=2))[..., 0]
        picture = np.maximum(picture, 0)
        across, down = np.meshgrid(np.arange(lens.width), np.arange(lens.height))
        centroid = np.array([(picture * across).sum(), (picture * down).sum()]) / picture.sum()
        assert np.abs(centroid - lens.pixels(point)).max() < 0.05  # px: the blob itself is bent a little


def placed(position: tuple, target: tuple) -> PlacedCamera:
    lens = Intrinsics(1920, 1080, (1300.0, 1300.0), (959.5, 539.5), (-0.09, 0.02, 0.0, 0.0, 0.0))
    view = View(lens, look_at(np.array(position), np.array(target)), np.array(position))
    return PlacedCamera(view, np.zeros((6, 6)), 0.0, ())


CAMERAS = [placed((14, -26, 2), (14, 0, 5)), placed((21, 23, 16), (15, 0, 5)), placed((6, 22, 4), (12, 0, 6))]
OFFSET = np.array([[0.3] * 4, [-0.3] * 4, [-0.3] * 4])  # camera 1 sees the right side
LATERAL = np.array([0.1, 0.2, -0.1, 0.0])


def planted(slewing: np.ndarray) -> np.ndarray:
    """Markers along a boom at lateral distances from its plane, (n, 4, 3)."""
    along = np.array([4.0, 9.0, 14.0, 20.0])
    direction = np.stack([np.cos(slewing), np.sin(slewing), 0 * slewing], -1)[:, None]
    side = right_hand(slewing)[:, None]
    return along[:, None] * direction + LATERAL[:, None] * side + np.array([0, 0, 4.0])


def sightings(markers: np.ndarray, slewing: np.ndarray) -> list[np.ndarray]:
    shift = [offset[:, None] * right_hand(slewing)[:, None] for offset in OFFSET]
    inside = [camera.view.in_camera(markers + off) for camera, off in zip(CAMERAS, shift)]
    return [points[..., :2] / points[..., 2:] for points in inside]


def test_back_projection_returns_what_was_planted() -> None:
    slewing = np.radians([-6.0, 0.0, 8.0])
    markers = planted(slewing)
    deviation = [np.full((3, 4), 0.02)] * 3
    found = back_project(CAMERAS, sightings(markers, slewing), deviation, OFFSET, LATERAL)
    assert np.abs(found.position - markers).max() < 1e-6
    assert np.abs(found.slewing - slewing).max() < 1e-7


def test_a_wrong_match_is_left_out_and_an_undecidable_one_gives_no_position() -> None:
    slewing = np.zeros(2)
    markers, ideal = planted(slewing), sightings(planted(slewing), slewing)
    ideal[0][0, 1] += 30 / 1300  # three cameras: the other two decide
    ideal[0][1, 2] += 30 / 1300
    ideal[2][1, 2] = np.nan  # two cameras: nobody decides
    found = back_project(CAMERAS, ideal, [np.full((2, 4), 0.02)] * 3, OFFSET, LATERAL)
    assert np.abs(found.position[0] - markers[0]).max() < 1e-5
    assert np.isnan(found.position[1, 2]).all() and np.isfinite(found.position[1, [0, 1, 3]]).all()
    assert found.cameras[0, 1] == 2 and found.contradictory == 1


def test_a_marker_between_opposite_cameras_does_not_turn_the_boom() -> None:
    rng, slewing = np.random.default_rng(5), np.zeros(30)
    markers = planted(slewing)
    markers[:, 3] = CAMERAS[0].view.position + 0.531 * (CAMERAS[1].view.position - CAMERAS[0].view.position)
    lateral = -markers[0, :, 1]
    noisy = [points + 0.1 / 1300 * rng.normal(size=points.shape) for points in sightings(markers, slewing)]
    noisy[2][:, 3] = np.nan  # its y is nearly free
    found = back_project(CAMERAS, noisy, [np.full((30, 4), 0.1)] * 3, OFFSET, lateral)
    assert np.abs(found.slewing).max() < 0.001  # rad: 10 mm at the third marker


@pytest.mark.parametrize("far_off", [0.0, 3.0])  # of the ideal point: a wrong match may lie anywhere
def test_a_marker_that_one_camera_sees_has_no_position(far_off: float) -> None:
    slewing = np.zeros(1)
    markers, ideal = planted(slewing), sightings(planted(slewing), slewing)
    ideal[0][0, 3] += far_off
    ideal[1][0, 3] = ideal[2][0, 3] = np.nan
    found = back_project(CAMERAS, ideal, [np.full((1, 4), 0.02)] * 3, OFFSET, LATERAL)
    assert np.isnan(found.position[0, 3]).all() and found.contradictory == 0
    assert np.abs(found.position[0, :3] - markers[0, :3]).max() < 1e-6


def test_covariance_is_the_scatter() -> None:
    rng, slewing = np.random.default_rng(3), np.zeros(400)
    markers, sigma = planted(slewing), 0.3
    noisy = [points + sigma / 1300 * rng.normal(size=points.shape) for points in sightings(markers, slewing)]
    found = back_project(CAMERAS, noisy, [np.full((400, 4), sigma)] * 3, OFFSET, LATERAL)
    error = found.position - markers
    square = np.einsum("nma,nmab,nmb->nm", error, np.linalg.inv(found.covariance), error)
    # chi square of 3 degrees; the 0.05 px of the model add 3 %, distortion shrinks pixels at the border by some more
    assert 2.3 < square.mean() < 3.4
