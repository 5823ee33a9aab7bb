"""COCO: annotations.json with the plates as keypoints of the boom, and outlines of boom, links and plates.

Keypoints follow COCO: the centre of the upper left pixel is (0.5, 0.5) there, so half a pixel is added; visibility 2 in
sight, 1 hidden behind something, 0 outside the picture. Outlines are polygons of what a link covers, hidden or not;
with masks, links carry what is in sight instead, as uncompressed run lengths.
"""

from pathlib import Path
from typing import Any

import cv2
import numpy as np

from boom_mj.cameras.dataset import Dataset, read_picture, write_json
from boom_mj.cameras.formats.labels import each_label

Array = np.ndarray
BOOM, PLATE, FIRST_LINK = 1, 2, 3
IN_SIGHT = 0.5  # share of a plate that must be seen for visibility 2


def write_coco(folder: Path, dataset: Dataset, bodies: list[str]) -> None:
    """Write annotations.json.

    Args:
        bodies: of the model, by number; masks hold these numbers.
    """
    marker_plates = [plate.name for plate in dataset.plates if plate.marker]
    links = sorted({body.partition("_")[0] for body in bodies if body.startswith("link")})
    images, annotations = [], []
    for number, file, label in each_label(folder, dataset):
        images.append(
            {
                "id": number,
                "file_name": file,
                "width": label["width"],
                "height": label["height"],
                "camera": label["camera"],
                "time": label["time"],
            }
        )
        mask = _mask(folder, file)
        found = [_boom(label, marker_plates)]
        for k, link in enumerate(links):
            numbers = [n for n, body in enumerate(bodies) if body.partition("_")[0] == link]
            found.append({"category_id": FIRST_LINK + k, **_link(label, link, mask, numbers)})
        found += [_plate(label["plates"][name], label) for name in marker_plates]
        annotations += [{"image_id": number, "iscrowd": 0, **a} for a in found if a.get("area", 0) > 0]
    for k, annotation in enumerate(annotations):
        annotation["id"] = k + 1
    boom = {"id": BOOM, "name": "boom", "supercategory": "machine", "keypoints": marker_plates}
    boom["skeleton"] = [[k, k + 2] for k in range(1, len(marker_plates) - 1)]
    categories = [boom, {"id": PLATE, "name": "plate", "supercategory": "target"}]
    categories += [{"id": FIRST_LINK + k, "name": link, "supercategory": "machine"} for k, link in enumerate(links)]
    info = {"description": f"{dataset.name}: {dataset.description}", "version": "1.0"}
    document = {"info": info, "licenses": [], "images": images, "annotations": annotations, "categories": categories}
    write_json(folder / "annotations.json", document)


def _boom(label: dict[str, Any], plates: list[str]) -> dict[str, Any]:
    keypoints: list[float] = []
    for name in plates:
        plate = label["plates"][name]
        u, v = plate["pixel"]
        inside = u is not None and -0.5 <= u < label["width"] - 0.5 and -0.5 <= v < label["height"] - 0.5
        keypoints += (
            [round(u + 0.5, 3), round(v + 0.5, 3), 2 if plate["visible"] >= IN_SIGHT else 1] if inside else [0] * 3
        )
    polygons = [_flat(body["outline"]) for body in label["bodies"].values() if len(body["outline"]) > 2]
    known = {"category_id": BOOM, "keypoints": keypoints, "num_keypoints": sum(v > 0 for v in keypoints[2::3])}
    return {**known, **_polygons(polygons)}


def _link(label: dict[str, Any], link: str, mask: Array | None, numbers: list[int]) -> dict[str, Any]:
    if mask is not None:
        return _run_lengths(np.isin(mask, numbers))
    outlines = [body["outline"] for name, body in label["bodies"].items() if name.partition("_")[0] == link]
    return _polygons([_flat(outline) for outline in outlines if len(outline) > 2])


def _plate(plate: dict[str, Any], label: dict[str, Any]) -> dict[str, Any]:
    if plate["visible"] == 0 or any(value is None for corner in plate["corners"] for value in corner):
        return {"area": 0}
    frame = np.array([(0, 0), (label["width"], 0), (label["width"], label["height"]), (0, label["height"])]) - 0.5
    corners = np.array(plate["corners"], np.float32)
    _, inside = cv2.intersectConvexConvex(corners, frame.astype(np.float32))
    if inside is None:
        return {"area": 0}
    return {"category_id": PLATE, "visible": plate["visible"], **_polygons([_flat(inside[:, 0].tolist())])}


def _flat(outline: list[list[float]]) -> list[float]:
    """x, y, x, y, .. in COCO's pixels."""
    return [round(value + 0.5, 2) for point in outline for value in point]


def _polygons(polygons: list[list[float]]) -> dict[str, Any]:
    if not polygons:
        return {"area": 0}
    points = np.concatenate([np.reshape(p, (-1, 2)) for p in polygons])
    area = sum(cv2.contourArea(np.reshape(p, (-1, 1, 2)).astype(np.float32)) for p in polygons)
    low, high = points.min(axis=0), points.max(axis=0)
    box = np.round([*low, *(high - low)], 2).tolist()
    return {"segmentation": polygons, "area": round(float(area), 2), "bbox": box}


def _run_lengths(mask: Array) -> dict[str, Any]:
    """Uncompressed run lengths, column by column, beginning with what is outside."""
    if not mask.any():
        return {"area": 0}
    flat = mask.ravel(order="F")
    changes = np.flatnonzero(flat[1:] != flat[:-1]) + 1
    ends = np.concatenate([[0] if not flat[0] else [0, 0], changes, [flat.size]])
    rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    box = [columns[0], rows[0], columns[-1] - columns[0] + 1, rows[-1] - rows[0] + 1]
    lengths = {"counts": np.diff(ends).tolist(), "size": list(mask.shape)}
    return {"segmentation": lengths, "area": int(mask.sum()), "bbox": [int(value) for value in box]}


def _mask(folder: Path, file: str) -> Array | None:
    path = (folder / file.replace("images/", "masks/", 1)).with_suffix(".png")
    return read_picture(path, cv2.IMREAD_UNCHANGED) if path.is_file() else None
