"""BOP: the links' boxes as objects with 6D poses, in bop/, one scene per camera.

    bop/camera.json, bop/models/obj_000001.ply .., bop/models/models_info.json, bop/models_eval/ (the same)
    bop/test/000001/{scene_camera,scene_gt,scene_gt_info}.json, rgb/, mask/, mask_visib/ (with masks), depth/

Lengths in mm. The layout knows pinhole cameras only: pictures, masks and depth of a lens are straightened, and all
labels are made anew for the pinhole camera with its K.
"""

import os
import shutil
from pathlib import Path
from typing import Any

import cv2
import mujoco
import numpy as np

from boom_mj.cameras.dataset import DEPTH_UNIT, Dataset, read_picture, write_json
from boom_mj.cameras.formats.labels import each_label
from boom_mj.cameras.intrinsics import Intrinsics
from boom_mj.cameras.labels import boom_bodies, box_corners, outline
from boom_mj.cameras.lens import Lens
from boom_mj.cameras.view import View
from boom_mj.files import write_bytes

Array = np.ndarray
MM = 1000.0
SPLIT = "test"


def write_bop(folder: Path, dataset: Dataset, model: mujoco.MjModel) -> None:
    """Write bop/ beside the pictures; without distortion these are linked, not copied, where the disk allows."""
    root, bodies = folder / "bop", boom_bodies(model)
    _write_models(root, model, bodies)
    numbers = {body: model.body(body).id for body in bodies}
    scenes = {camera.name: k + 1 for k, camera in enumerate(dataset.cameras)}
    records: dict[str, dict[str, dict[str, Any]]] = {name: {"camera": {}, "gt": {}, "gt_info": {}} for name in scenes}
    corners = {body: box_corners(model, body) for body in bodies}
    lenses: dict[str, Lens] = {}
    for _, file, label in each_label(folder, dataset):
        name, key = label["camera"], str(label["number"])
        scene = root / SPLIT / f"{scenes[name]:06d}"
        pose, record = np.array(label["camera_from_world"]), records[name]
        lens = lenses.setdefault(name, _lens(label))
        view = View(lens.intrinsics.pinhole, pose[:3, :3], -pose[:3, :3].T @ pose[:3, 3])
        record["camera"][key] = {
            "cam_K": np.array(label["K"]).ravel().tolist(),
            "cam_R_w2c": pose[:3, :3].ravel().tolist(),
            "cam_t_w2c": (MM * pose[:3, 3]).tolist(),
            "depth_scale": MM * DEPTH_UNIT,
        }
        record["gt"][key] = [_truth(pose, k + 1, label["bodies"][body]) for k, body in enumerate(bodies)]
        seen = _beside(folder, file, "masks")
        seen = None if seen is None else lens.straightened(seen, exact=True)
        record["gt_info"][key] = []
        for k, body in enumerate(bodies):
            covered = _covered(view, corners[body], label["bodies"][body])
            visible = covered if seen is None else (covered > 0) & (seen == numbers[body])
            record["gt_info"][key].append(_info(covered, visible))
            if seen is not None:
                stem = f"{label['number']:06d}_{k:06d}.png"
                for place, mask in (("mask", covered), ("mask_visib", visible)):
                    write_bytes(scene / place / stem, _png(np.where(mask, 255, 0).astype(np.uint8)))
        _place(folder / file, scene / "rgb" / Path(file).name, lens, exact=False)
        depth = (folder / file.replace("images/", "depth/", 1)).with_suffix(".png")
        if depth.is_file():
            _place(depth, scene / "depth" / depth.name, lens, exact=True)
    for name, number in scenes.items():
        for part, content in records[name].items():
            write_json(root / SPLIT / f"{number:06d}" / f"scene_{part}.json", content)
    first = next(iter(records[dataset.cameras[0].name]["camera"].values()))["cam_K"]
    size = dataset.cameras[0]
    camera = {"cx": first[2], "cy": first[5], "depth_scale": MM * DEPTH_UNIT, "fx": first[0], "fy": first[4]}
    write_json(root / "camera.json", {**camera, "width": size.width, "height": size.height}, indent=1)
    targets = [
        {"im_id": int(key), "inst_count": 1, "obj_id": truth["obj_id"], "scene_id": scenes[name]}
        for name, record in records.items()
        for key, truths in record["gt"].items()
        for truth in truths
    ]
    write_json(root / "test_targets_bop19.json", targets)


def _truth(camera: Array, number: int, body: dict[str, Any]) -> dict[str, Any]:
    rotation = np.zeros(9)
    mujoco.mju_quat2Mat(rotation, np.array(body["quaternion"]))
    turned = camera[:3, :3] @ rotation.reshape(3, 3)
    place = MM * (camera[:3, :3] @ body["position"] + camera[:3, 3])
    return {
        "cam_R_m2c": np.round(turned, 9).ravel().tolist(),
        "cam_t_m2c": np.round(place, 4).tolist(),
        "obj_id": number,
    }


def _info(covered: Array, visible: Array) -> dict[str, Any]:
    whole, part = int(np.count_nonzero(covered)), int(np.count_nonzero(visible))
    return {
        "bbox_obj": _box(covered),
        "bbox_visib": _box(visible),
        "px_count_all": whole,
        "px_count_valid": whole,
        "px_count_visib": part,
        "visib_fract": round(part / whole, 6) if whole else 0.0,
    }


def _box(mask: Array) -> list[int]:
    """x, y, width, height; -1 where there is nothing."""
    rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    if not len(rows):
        return [-1, -1, -1, -1]
    return [int(columns[0]), int(rows[0]), int(columns[-1] - columns[0] + 1), int(rows[-1] - rows[0] + 1)]


def _lens(label: dict[str, Any]) -> Lens:
    matrix = np.array(label["K"])
    focal, center = (matrix[0, 0], matrix[1, 1]), (matrix[0, 2], matrix[1, 2])
    return Lens(Intrinsics(label["width"], label["height"], focal, center, tuple(label["distortion"])))


def _covered(view: View, corners: Array, body: dict[str, Any]) -> Array:
    """Pixels that a box covers, hidden or not, (h, w) uint8."""
    rotation, lens = np.zeros(9), view.intrinsics
    mujoco.mju_quat2Mat(rotation, np.array(body["quaternion"]))
    found = outline(view.project(corners @ rotation.reshape(3, 3).T + body["position"]), view)
    mask = np.zeros((lens.height, lens.width), np.uint8)
    if len(found) > 2:
        cv2.fillConvexPoly(mask, np.round(16 * found).astype(np.int32), 1, shift=4)
    return mask


def _beside(folder: Path, file: str, kind: str) -> Array | None:
    path = (folder / file.replace("images/", f"{kind}/", 1)).with_suffix(".png")
    return read_picture(path, cv2.IMREAD_UNCHANGED) if path.is_file() else None


def _place(source: Path, target: Path, lens: Lens, exact: bool) -> None:
    """A picture as the pinhole camera has it: a second name for the file where the lens does not distort."""
    target.parent.mkdir(parents=True, exist_ok=True)
    target.unlink(missing_ok=True)
    if lens.intrinsics != lens.intrinsics.pinhole:
        straight = lens.straightened(read_picture(source, cv2.IMREAD_UNCHANGED), exact)
        write_bytes(target, cv2.imencode(target.suffix, straight)[1].tobytes())
        return
    try:
        os.link(source, target)
    except OSError:
        shutil.copyfile(source, target)


def _write_models(root: Path, model: mujoco.MjModel, bodies: list[str]) -> None:
    info = {}
    for k, body in enumerate(bodies):
        corners = MM * box_corners(model, body)
        ply = _ply(corners, _triangles(model, body))
        for place in ("models", "models_eval"):
            write_bytes(root / place / f"obj_{k + 1:06d}.ply", ply)
        low, size = corners.min(axis=0), np.ptp(corners, axis=0)
        diameter = max(float(np.linalg.norm(a - b)) for a in corners for b in corners)
        names = ("min_x", "min_y", "min_z", "size_x", "size_y", "size_z")
        info[str(k + 1)] = {"diameter": diameter, **dict(zip(names, [*low.tolist(), *size.tolist()])), "name": body}
    for place in ("models", "models_eval"):
        write_json(root / place / "models_info.json", info, indent=1)


def _triangles(model: mujoco.MjModel, body: str) -> Array:
    """Faces of the box of a body, (m, 3)."""
    first, count = int(model.body(body).geomadr[0]), int(model.body(body).geomnum[0])
    geom = next(g for k in range(first, first + count) if not (g := model.geom(k)).name and g.dataid[0] >= 0)
    mesh = model.mesh(int(geom.dataid[0]))
    return np.asarray(model.mesh_face[int(mesh.faceadr[0]) :][: int(mesh.facenum[0])])


def _ply(corners: Array, triangles: Array) -> bytes:
    """Text PLY with normals, as the BOP toolkit reads it."""
    away = corners - corners.mean(axis=0)
    normals = away / np.linalg.norm(away, axis=1, keepdims=True)
    names = "".join(f"property float {n}\n" for n in ("x", "y", "z", "nx", "ny", "nz"))
    head = f"ply\nformat ascii 1.0\nelement vertex {len(corners)}\n{names}"
    head += f"element face {len(triangles)}\nproperty list uchar int vertex_indices\nend_header\n"
    rows = [" ".join(f"{value:.4f}" for value in row) for row in np.hstack([corners, normals])]
    faces = [f"3 {a} {b} {c}" for a, b, c in triangles]
    return (head + "\n".join([*rows, *faces]) + "\n").encode()


def _png(picture: Array) -> bytes:
    return cv2.imencode(".png", picture)[1].tobytes()
