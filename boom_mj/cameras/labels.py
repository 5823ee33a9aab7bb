"""What is true of a frame: camera, joints, elastic coordinates, where everything is and what of it is in sight."""

from typing import Any

import cv2
import mujoco
import numpy as np

from boom_mj.cameras.studio import Studio
from boom_mj.cameras.targets import Plate
from boom_mj.cameras.view import View

Array = np.ndarray
GRID = np.array([(u, v) for v in (-0.4, 0.0, 0.4) for u in (-0.42, -0.21, 0.0, 0.21, 0.42)])
DIGITS = 6  # of lengths in m and angles in rad; pixels have 4


def label(studio: Studio, name: str, view: View) -> dict[str, Any]:
    """Labels of what a camera sees of the boom as it is posed now, ready for JSON.

    Lengths in m and in the world frame, angles in rad; pixels as in OpenCV, null behind the camera. `visible` is the
    share of a plate that is in the picture with nothing before it. `outline` is what a body covers, hidden or not.
    """
    film, data, lens = studio.film, studio.data, view.intrinsics
    markers = np.array([data.site(f"marker{k}").xpos for k in sorted({p.marker for p in film.plates} - {0})])
    return {
        "camera": name,
        "width": lens.width,
        "height": lens.height,
        "K": _rounded(lens.matrix, 9),
        "distortion": list(lens.distortion),
        "camera_from_world": _rounded(np.vstack([np.c_[view.rotation, view.translation], [0, 0, 0, 1]]), 9),
        "joints": _rounded(data.qpos[film.joints], 9),
        "ritz": _rounded(film.ritz @ data.qpos, 9),
        "markers": _rounded(markers, DIGITS),
        "marker_pixels": _rounded(view.project(markers), 4),
        "plates": {plate.name: _plate(studio, view, plate) for plate in film.plates},
        "bodies": {body: _body(studio, view, body) for body in boom_bodies(studio.model)},
    }


def boom_bodies(model: mujoco.MjModel) -> list[str]:
    """Names of the bodies that the links are made of, root outward."""
    return [name for k in range(model.nbody) if (name := model.body(k).name).startswith("link")]


def _plate(studio: Studio, view: View, plate: Plate) -> dict[str, Any]:
    body = studio.data.body(plate.body)
    rotation, position = body.xmat.reshape(3, 3), body.xpos
    center, corners = position + rotation @ plate.center, position + plate.corners @ rotation.T
    grid = center + (GRID * plate.size) @ (rotation @ plate.axes[:, :2]).T
    faces = (view.position - center) @ (rotation @ plate.axes[:, 2]) > 0
    seen = view.intrinsics.contains(view.project(grid)) & faces
    if seen.any():
        seen &= studio.visible(view, grid, plate.name)
    return {
        "center": _rounded(center, DIGITS),
        "pixel": _rounded(view.project(center), 4),
        "corners": _rounded(view.project(corners), 4),
        "visible": round(float(seen.mean()), 3),
    }


def _body(studio: Studio, view: View, name: str) -> dict[str, Any]:
    body = studio.data.body(name)
    points = body.xpos + box_corners(studio.model, name) @ body.xmat.reshape(3, 3).T
    pixels = view.project(points)
    return {
        "position": _rounded(body.xpos, DIGITS),
        "quaternion": _rounded(body.xquat, 9),
        "outline": _rounded(outline(pixels, view), 2),
    }


def box_corners(model: mujoco.MjModel, body: str) -> Array:
    """Corners of the box of a body of the boom in its frame, (8, 3), m."""
    geom = _mesh_geom(model, body)
    mesh = model.mesh(int(geom.dataid[0]))
    start, count = int(mesh.vertadr[0]), int(mesh.vertnum[0])
    rotation = np.zeros(9)
    mujoco.mju_quat2Mat(rotation, geom.quat)
    return np.asarray(model.mesh_vert[start : start + count] @ rotation.reshape(3, 3).T + geom.pos)


def _mesh_geom(model: mujoco.MjModel, body: str) -> Any:
    """The unnamed geom that draws the box of a body."""
    first, count = int(model.body(body).geomadr[0]), int(model.body(body).geomnum[0])
    boxes = (model.geom(k) for k in range(first, first + count))
    return next(g for g in boxes if g.type[0] == mujoco.mjtGeom.mjGEOM_MESH and not g.name)


def outline(pixels: Array, view: View) -> Array:
    """Convex outline of pixels, (k, 2), NaN left out, within the picture, (m, 2); empty where there is none."""
    pixels = pixels[np.isfinite(pixels).all(axis=1)]
    if len(pixels) < 3:
        return np.zeros((0, 2))
    lens = view.intrinsics
    frame = np.array([(0, 0), (lens.width, 0), (lens.width, lens.height), (0, lens.height)]) - 0.5
    hull = cv2.convexHull(pixels.astype(np.float32))
    area, inside = cv2.intersectConvexConvex(hull, frame.astype(np.float32)) if len(hull) > 2 else (0.0, None)
    return np.zeros((0, 2)) if not area or inside is None else inside[:, 0].astype(float)


def _rounded(values: Array, digits: int) -> Any:
    """Nested lists with null for NaN."""
    rounded = np.round(np.asarray(values, float), digits) + 0.0  # no -0.0
    plain = rounded.astype(object)
    plain[np.isnan(rounded)] = None
    return plain.tolist()
