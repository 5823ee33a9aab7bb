"""nerfstudio: transforms.json, for radiance fields and whoever reads camera poses the way Blender writes them.

Camera axes there: x right, y up, z backward; pixels: the upper left corner of the picture is (0, 0), so that the
principal point is half a pixel larger than OpenCV's.
"""

from pathlib import Path
from typing import Any

import numpy as np

from boom_mj.cameras.dataset import DEPTH_UNIT, Dataset, write_json
from boom_mj.cameras.formats.labels import each_label


def write_nerfstudio(folder: Path, dataset: Dataset) -> None:
    """Write transforms.json."""
    frames = [_frame(folder, file, label) for _, file, label in each_label(folder, dataset)]
    document: dict[str, Any] = {"camera_model": "OPENCV", "orientation_override": "none", "frames": frames}
    if any("depth_file_path" in frame for frame in frames):
        document["depth_unit_scale_factor"] = DEPTH_UNIT
    write_json(folder / "transforms.json", document)


def _frame(folder: Path, file: str, label: dict[str, Any]) -> dict[str, Any]:
    pose, matrix = np.array(label["camera_from_world"]), np.array(label["K"])
    world = np.linalg.inv(pose) @ np.diag([1.0, -1.0, -1.0, 1.0])
    k1, k2, p1, p2, k3 = label["distortion"]
    frame = {
        "file_path": file,
        "w": label["width"],
        "h": label["height"],
        "fl_x": matrix[0, 0],
        "fl_y": matrix[1, 1],
        "cx": matrix[0, 2] + 0.5,
        "cy": matrix[1, 2] + 0.5,
        **{"k1": k1, "k2": k2, "k3": k3, "p1": p1, "p2": p2},
        "transform_matrix": np.round(world, 9).tolist(),
        "time": label["time"],
    }
    depth = str(Path(file.replace("images/", "depth/", 1)).with_suffix(".png"))
    return {**frame, "depth_file_path": depth} if (folder / depth).is_file() else frame
