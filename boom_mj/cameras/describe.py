"""The description of a data set that is to be rendered."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from boom_mj.cameras.chequerboard import VIEWS
from boom_mj.cameras.dataset import CameraEntry, Dataset, PictureEntry, PlateEntry
from boom_mj.cameras.film import Film
from boom_mj.cameras.shooting import Frame, Look
from boom_mj.cameras.targets import SIDES, Plate, plate_picture
from boom_mj.files import write_bytes
from boom_mj.machine import Machine, sections

Array = np.ndarray


def describe(
    film: Film,
    frames: list[Frame],
    look: Look,
    calibration: bool,
    name: str,
    description: str,
    origin: Mapping[str, Any],
) -> Dataset:
    """What dataset.json says of frames to be taken.

    Args:
        calibration: whether every camera is shown the chequerboard.
        origin: what else decides the pictures; a folder is only resumed with the same.
    """
    boards = [
        PictureEntry(camera=camera.name, file=f"calibration/{camera.name}/{k:02d}.png")
        for camera in film.rig
        for k in range(VIEWS if calibration else 0)
    ]
    pictures = [PictureEntry(camera=f.camera, file=f.place("images", look.suffix), stamp=f.stamp) for f in frames]
    lenses = {camera.name: camera.view.intrinsics for camera in film.rig}
    return Dataset(
        name=name,
        machine=film.machine.name,
        description=description,
        cameras=tuple(CameraEntry(name=n, width=lens.width, height=lens.height) for n, lens in lenses.items()),
        plates=tuple(_entry(plate) for plate in film.plates),
        lateral=tuple(lateral_of_markers(film.machine)),
        chequerboard=film.machine.targets.chequerboard,
        calibration=tuple(boards),
        frames=tuple(pictures),
        still="pose" not in look.randomise,
        origin={**origin, "motion": _digest(film), "rig": [camera.file.model_dump(mode="json") for camera in film.rig]},
    )


def write_plates(film: Film, folder: Path) -> None:
    """The pictures of all plates."""
    for plate in film.plates:
        entry, picture = _entry(plate), plate_picture(plate.name, plate.size)
        write_bytes(folder / entry.picture, cv2.imencode(".png", picture)[1].tobytes())


def lateral_of_markers(machine: Machine) -> list[float]:
    """How far every marker lies to the right of the vertical plane through the slewing axis, rigid boom, m."""
    found, reached = [], 0.0
    for link in machine.links:
        x = np.array(machine.sensors.markers_x) * link.length
        found += (reached + sections.offset(link, machine.offset_profile.kind, x)).round(6).tolist()
        reached += link.offset
    return found


def _entry(plate: Plate) -> PlateEntry:
    picture = f"plates/{plate.name}.png"
    if plate.marker:
        side = next(side for side, sign in SIDES.items() if sign * plate.offset > 0)
        return PlateEntry(
            name=plate.name, picture=picture, size=plate.size, marker=plate.marker, side=side,
            offset=round(abs(plate.offset), 6),
        )  # fmt: skip
    right, up = (tuple(np.round(axis, 9).tolist()) for axis in plate.axes.T[:2])
    return PlateEntry(
        name=plate.name, picture=picture, size=plate.size, center=tuple(plate.center.tolist()), right=right, up=up
    )


def _digest(film: Film) -> list[float]:
    """A few numbers that tell one motion from another, whatever processor it was simulated on."""
    steps = np.linspace(0, len(film.time) - 1, 7).astype(int)
    return [round(float(film.time[-1]), 6), *np.round(film.qpos[steps].sum(axis=1), 5).tolist()]
