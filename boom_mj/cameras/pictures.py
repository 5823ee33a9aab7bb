"""Pictures to look at: contact sheet, overlay of projected and tracked markers, video."""

from pathlib import Path

import cv2
import numpy as np

from boom_mj.cameras.chain import Tracking
from boom_mj.cameras.dataset import Dataset, read_picture
from boom_mj.cameras.video import write_video
from boom_mj.errors import RenderError
from boom_mj.files import write_bytes

Array = np.ndarray
MEASURED, PROJECTED = (0, 94, 213), (178, 114, 0)  # vermilion and blue, as OpenCV orders colours
SHEET_WIDTH, GAP = 1600, 6  # px


def contact_sheet(folder: Path, dataset: Dataset, path: Path, rows: int = 4) -> None:
    """A few instants down, the cameras across."""
    columns = []
    for camera in dataset.cameras:
        files = [frame.file for frame in dataset.frames if frame.camera == camera.name]
        chosen = [files[k] for k in np.linspace(0, len(files) - 1, min(rows, len(files))).astype(int)]
        columns.append([_shrunk(_read(folder / file), SHEET_WIDTH // len(dataset.cameras) - GAP) for file in chosen])
    height = min(len(column) for column in columns)
    lines = [np.hstack([_framed(column[k]) for column in columns]) for k in range(height)]
    write_bytes(path, _encoded(np.vstack(lines), path))


def overlay(folder: Path, tracking: Tracking, time: float, path: Path) -> None:
    """Every camera at an instant: outlines of the tracked plates, crosses where the positions project to.

    Whole pictures above, below them what is around the outermost marker in sight, pixel by pixel.
    """
    names = list(tracking.tracks)
    width = SHEET_WIDTH // len(names) - GAP
    whole = [_framed(annotated(folder, tracking, name, time, width)) for name in names]
    height = max(picture.shape[0] for picture in whole)
    near = [_framed(_around_tip(folder, tracking, name, time, (width, height - GAP))) for name in names]
    rows = [[_padded(picture, height) for picture in row] for row in (whole, near)]
    write_bytes(path, _encoded(np.vstack([np.hstack(row) for row in rows]), path))


def _around_tip(folder: Path, tracking: Tracking, camera: str, time: float, size: tuple[int, int]) -> Array:
    """The part of a picture around the last marker that a camera sees, (height, width, 3)."""
    picture = annotated(folder, tracking, camera, time)
    view = tracking.places[camera].view
    pixels = view.project(tracking.positions.position[int(np.argmin(np.abs(tracking.time - time)))])
    inside = pixels[view.intrinsics.contains(pixels)]
    middle = inside[-1] if len(inside) else np.array(picture.shape[1::-1]) / 2
    limit = np.maximum(np.array(picture.shape[1::-1]) - size, 0)
    left, top = np.clip(middle - np.array(size) / 2, 0, limit).astype(int)
    return picture[top : top + size[1], left : left + size[0]]


def video(folder: Path, tracking: Tracking, camera: str, path: Path, width: int = 960, speed: float = 1.0) -> None:
    """All frames of a camera with their overlay, as WebM."""
    stamps = tracking.tracks[camera].stamp
    rate = (len(stamps) - 1) / (stamps[-1] - stamps[0]) * speed if len(stamps) > 1 else 1.0
    write_video(path, (annotated(folder, tracking, camera, stamp, width) for stamp in stamps), rate)


def annotated(folder: Path, tracking: Tracking, camera: str, time: float, width: int | None = None) -> Array:
    """The frame of a camera nearest to a time, with plates as they were tracked and markers as they project.

    Args:
        width: to shrink the picture to before anything is drawn, px.
    """
    track, view = tracking.tracks[camera], tracking.places[camera].view
    frames = sorted((f for f in tracking.dataset.frames if f.camera == camera), key=lambda frame: frame.stamp)
    row = int(np.argmin(np.abs(track.stamp - time)))
    picture = _read(folder / frames[row].file)
    factor = min(1.0, width / picture.shape[1]) if width else 1.0
    picture = _shrunk(picture, round(factor * picture.shape[1]))
    plates = {plate.name: plate for plate in tracking.dataset.plates}
    for k, name in enumerate(track.names):
        sighting = track.sighting(row, k)
        if sighting is not None:
            corners = sighting.corners(view.intrinsics, plates[name].size)
            _outline(picture, (corners + 0.5) * factor - 0.5, 1 if factor < 1 else 2)
    nearest = int(np.argmin(np.abs(tracking.time - time)))
    pixels = view.project(tracking.positions.position[nearest])
    for number in np.flatnonzero(view.intrinsics.contains(pixels)):
        _cross(picture, (pixels[number] + 0.5) * factor - 0.5, str(number + 1))
    return picture


def _outline(picture: Array, corners: Array, width: int) -> None:
    points = np.round(corners * 16).astype(np.int32)
    cv2.polylines(picture, [points], True, MEASURED, width, cv2.LINE_AA, 4)


def _cross(picture: Array, pixel: Array, text: str) -> None:
    place = (round(float(pixel[0])), round(float(pixel[1])))
    cv2.drawMarker(picture, place, PROJECTED, cv2.MARKER_CROSS, 12, 1, cv2.LINE_AA)
    where = (place[0] + 5, place[1] - 9)
    cv2.putText(picture, text, where, cv2.FONT_HERSHEY_SIMPLEX, 0.45, PROJECTED, 1, cv2.LINE_AA)


def _read(path: Path) -> Array:
    return read_picture(path, cv2.IMREAD_COLOR)


def _shrunk(picture: Array, width: int) -> Array:
    height = round(picture.shape[0] * width / picture.shape[1])
    return cv2.resize(picture, (width, height), interpolation=cv2.INTER_AREA) if width < picture.shape[1] else picture


def _framed(picture: Array) -> Array:
    half = GAP // 2
    return cv2.copyMakeBorder(picture, half, half, half, half, cv2.BORDER_CONSTANT, value=(255, 255, 255))


def _padded(picture: Array, height: int) -> Array:
    return cv2.copyMakeBorder(
        picture, 0, height - picture.shape[0], 0, 0, cv2.BORDER_CONSTANT, value=(255, 255, 255)
    )  # fmt: skip


def _encoded(picture: Array, path: Path) -> bytes:
    good, data = cv2.imencode(path.suffix, picture)
    if not good:
        raise RenderError(f"{path}: no such kind of picture")
    return data.tobytes()
