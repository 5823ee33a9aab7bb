"""How far our camera geometry is from OpenCV's, from MuJoCo's, and from what is rendered; see scripts/cameras.py."""

from itertools import product

import cv2
import numpy as np

from boom_mj.cameras.agreement import mujoco_projection
from boom_mj.cameras.dressing import THICKNESS
from boom_mj.cameras.film import film_of
from boom_mj.cameras.intrinsics import Intrinsics
from boom_mj.cameras.rig import rig_of
from boom_mj.cameras.studio import Studio
from boom_mj.cameras.targets import SIDES, Plate
from boom_mj.cameras.view import View
from boom_mj.machine import Machine
from boom_mj.simulation import CATALOGUE, make_plant, run_experiment

Array = np.ndarray


def projection_errors(machine: Machine) -> tuple[float, float]:
    """Largest distance of our pixels from OpenCV's, with distortion, and from MuJoCo's, without, px."""
    rng, ours_cv, ours_mujoco = np.random.default_rng(1), 0.0, 0.0
    for camera in rig_of(machine):
        view, lens = camera.view, camera.view.intrinsics
        pixels = rng.uniform(0, [lens.width - 1, lens.height - 1], (300, 2))
        inside = np.column_stack([lens.rays(pixels), np.ones(300)]) * rng.uniform(2, 60, (300, 1))
        points, turn = inside @ view.rotation + view.position, cv2.Rodrigues(view.rotation)[0]
        theirs = cv2.projectPoints(points, turn, view.translation, lens.matrix, np.array(lens.distortion))[0][:, 0]
        ours_cv = max(ours_cv, float(np.abs(view.project(points) - theirs).max()))
        centred = Intrinsics(lens.width, lens.height, lens.focal, ((lens.width - 1) / 2, (lens.height - 1) / 2))
        plain = View(centred, view.rotation, view.position)
        difference = plain.project(points) - mujoco_projection(plain, points)
        ours_mujoco = max(ours_mujoco, float(np.abs(difference).max()))
    return ours_cv, ours_mujoco


def centroid_errors(machine: Machine, name: str) -> Array:
    """Distances of the centroids of rendered marker plates from those of their projected outlines, px.

    Ideal lenses; plates that are wholly in sight. How much of a pixel a plate covers is the difference of two pictures:
    one with the plates of one side shining, one with black ones.
    """
    found = []
    film = film_of(run_experiment(make_plant(machine, 1), CATALOGUE[name]), rig_of(machine, distortion=False))
    groups = [[p for p in film.plates if p.name.partition("_")[2] == side] for side in SIDES]
    materials = [film.model.material(plate.name).id for plate in film.plates]
    film.model.mat_texid[materials], film.model.mat_specular[materials] = -1, 0
    with Studio(film) as studio:
        for time in (7.0, 8.6, 9.4):
            studio.pose(time)
            for camera, group in product([camera.name for camera in rig_of(machine)], groups):
                own, shown = [film.model.material(plate.name).id for plate in group], []
                film.model.mat_rgba[materials, :3], film.model.mat_emission[materials] = 0.0, 0.0
                for bright in (1.0, 0.0):
                    film.model.mat_rgba[own, :3], film.model.mat_emission[own] = bright, bright
                    shown.append(studio.picture(camera)[..., 1].astype(float))
                for plate in group:
                    outline, clear = _outline(studio, camera, plate)
                    if clear:
                        found.append(np.linalg.norm(_centroid(shown[0] - shown[1], outline) - _middle(outline)))
    return np.array(found)


def _outline(studio: Studio, camera: str, plate: Plate) -> tuple[Array, bool]:
    """What a plate and its edges cover, (n, 2) px, and whether all of it is in sight."""
    body, view = studio.data.body(plate.body), studio.view(camera)
    rotation = body.xmat.reshape(3, 3)
    corners, normal = body.xpos + plate.corners @ rotation.T, rotation @ plate.axes[:, 2]
    hull = cv2.convexHull(view.project(np.vstack([corners, corners - THICKNESS * normal])).astype(np.float32))[:, 0]
    if not view.intrinsics.contains(hull).all() or (view.position - corners.mean(axis=0)) @ normal <= 0:
        return hull, False
    share = np.linspace(0.005, 0.995, 15)
    across, down = np.meshgrid(share, share)
    along, up = corners[1] - corners[0], corners[3] - corners[0]
    grid = corners[0] + np.outer(across.ravel(), along) + np.outer(down.ravel(), up)
    return hull, bool(studio.visible(view, grid, plate.name).all())


def _centroid(cover: Array, outline: Array) -> Array:
    """Centroid of what is covered within an outline and a pixel around it, (2,) px."""
    low, high = np.floor(outline.min(axis=0)).astype(int) - 1, np.ceil(outline.max(axis=0)).astype(int) + 2
    mask = np.zeros(cover.shape, np.uint8)
    cv2.fillConvexPoly(mask, np.round(outline).astype(np.int32), 1)
    part = np.s_[low[1] : high[1], low[0] : high[0]]
    weight = cover[part] * cv2.dilate(mask[part], np.ones((3, 3), np.uint8))
    rows, columns = np.mgrid[part]
    return np.array([(weight * columns).sum(), (weight * rows).sum()]) / weight.sum()


def _middle(outline: Array) -> Array:
    """Centroid of a polygon, (2,)."""
    moments = cv2.moments(outline)
    return np.array([moments["m10"], moments["m01"]]) / moments["m00"]
