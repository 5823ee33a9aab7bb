"""The folder that a data set is: its description, and its files, which appear whole or not at all.

dataset.json     what `track` needs of any pictures, ours or others: cameras, plates, chequerboard, pictures, stamps
images/          CAMERA/000000.png
calibration/     CAMERA/00.png, the chequerboard
plates/          what every plate looks like, upright
labels/          CAMERA/000000.json, what is true of a frame; a frame that has its label is done
depth/, masks/   CAMERA/000000.png, on request: units of DEPTH_UNIT in 16 bits (0: sky), numbers of bodies
"""

import json
import os
from pathlib import Path
from typing import Annotated, Any

import cv2
import numpy as np
from pydantic import Field, FiniteFloat, ValidationError

from boom_mj.errors import DatasetError
from boom_mj.files import inside, png_pixels, read_bytes, write_bytes
from boom_mj.machine.fields import Frozen, Point3, Positive
from boom_mj.machine.rig import Chequerboard

DESCRIPTION = "dataset.json"
DEPTH_UNIT = 0.004  # m per grey level of depth pictures: 262 m in 16 bits, and the ground ends before
MOST_PIXELS = 2**28  # as many as the largest camera has
Pixels = Annotated[int, Field(ge=1, le=2**15)]


class CameraEntry(Frozen):
    """A camera: its name, and the size of its pictures in px."""

    name: str
    width: Pixels
    height: Pixels


class PlateEntry(Frozen):
    """A plate.

    Attributes:
        picture: file of what it looks like, upright.
        size: along its picture's rows and columns, m.
        marker: number of the marker it stands for; 0 for a reference plate.
        side: of the boom seen outward, "right" or "left"; of a marker plate.
        offset: from its marker, to that side, m (p_off of eq. 33).
        center, right, up: of a reference plate in the world: place, m, and directions of its picture.
    """

    name: str
    picture: str
    size: tuple[Positive, Positive]
    marker: int = 0
    side: str = ""
    offset: FiniteFloat = 0.0
    center: Point3 | None = None
    right: Point3 | None = None
    up: Point3 | None = None


class PictureEntry(Frozen):
    """A picture and the stamp of its camera's clock, s; pictures of a chequerboard have none."""

    camera: str
    file: str
    stamp: FiniteFloat = 0.0


class Dataset(Frozen):
    """What dataset.json holds.

    Attributes:
        lateral: of every marker, its distance to the right of the boom's vertical plane through the slewing axis, m.
        still: whether the cameras stand still.
        origin: how the pictures were made; free, and compared when a rendering is resumed.
    """

    name: str
    machine: str
    description: str = ""
    cameras: tuple[CameraEntry, ...]
    plates: tuple[PlateEntry, ...]
    lateral: tuple[FiniteFloat, ...]
    chequerboard: Chequerboard
    calibration: tuple[PictureEntry, ...] = ()
    frames: tuple[PictureEntry, ...]
    still: bool = True
    origin: dict[str, Any] = Field(default_factory=dict)


def read_dataset(folder: Path) -> Dataset:
    """The description of a folder of pictures.

    Raises:
        DatasetError: there is none, or it is none.
    """
    path = folder / DESCRIPTION
    if not path.is_file():
        raise DatasetError(f"{folder} is no folder of pictures: it needs a {DESCRIPTION}")
    content = read_bytes(path, DatasetError)
    try:
        dataset = Dataset.model_validate_json(content)
    except ValidationError as error:
        first = error.errors()[0]
        place = ".".join(str(part) for part in first["loc"])
        raise DatasetError(f"{path}: {place or 'the file'}: {first['msg'][0].lower()}{first['msg'][1:]}") from error
    named = {p.file for p in (*dataset.calibration, *dataset.frames)} | {plate.picture for plate in dataset.plates}
    for place in sorted({os.path.dirname(file) for file in named}):
        inside(folder, place, DatasetError, path)
    return dataset


def read_picture(path: Path, flags: int = cv2.IMREAD_GRAYSCALE) -> np.ndarray:
    """A picture, (h, w) uint8 unless OpenCV's flags say otherwise; of at most MOST_PIXELS.

    Raises:
        DatasetError: it is missing, no picture, or too large.
    """
    content = read_bytes(path, DatasetError)
    if (pixels := png_pixels(content)) > MOST_PIXELS:
        raise DatasetError(f"{path} has {pixels} pixels; up to {MOST_PIXELS} are read")
    try:
        picture = cv2.imdecode(np.frombuffer(content, np.uint8), flags) if content else None
    except cv2.error as error:
        raise DatasetError(f"{path} is damaged: {error.err}") from error
    if picture is None:
        raise DatasetError(f"{path} is no picture")
    return np.asarray(picture)


def claim_folder(folder: Path, dataset: Dataset) -> None:
    """Make a folder the data set's own, or find it begun.

    Raises:
        DatasetError: it holds something else; nothing is touched then.
    """
    if (folder / DESCRIPTION).is_file():
        there, wanted = read_dataset(folder).model_dump(mode="json"), dataset.model_dump(mode="json")
        if there != wanted:
            differs = [key for key in wanted["origin"] if wanted["origin"][key] != there["origin"].get(key)]
            differs = differs or [key for key in wanted if wanted[key] != there[key]]
            raise DatasetError(
                f"{folder} holds another data set ({there['name']}; it differs in {', '.join(differs)}): "
                "give the same arguments to finish it, or another folder"
            )
        return
    if folder.is_dir() and any(folder.iterdir()):
        found = ", ".join(sorted(path.name for path in folder.iterdir())[:3])
        raise DatasetError(f"{folder} holds something that is no data set ({found}): choose an empty or a new folder")
    write_json(folder / DESCRIPTION, dataset.model_dump(mode="json"), indent=1)


def write_json(path: Path, document: Any, indent: int | None = None) -> None:
    """Write a JSON file; equal documents give equal bytes."""
    separators = (",", ":") if indent is None else None
    write_bytes(path, json.dumps(document, indent=indent, separators=separators, allow_nan=False).encode())
