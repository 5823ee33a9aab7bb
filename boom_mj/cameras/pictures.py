"""Pictures to look at: contact sheet, overlay of projected and tracked markers, video."""

from pathlib import Path
from typing import Any

import cv2
import numpy as np

from boom_mj.cameras.chain import Tracking
from boom_mj.cameras.dataset import Dataset, write_bytes
from boom_mj.cameras.view import View
from boom_mj.errors import RenderError

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
    """Every camera at an instant: outlines of the tracked plates, crosses where the positions project to."""
    names = list(tracking.tracks)
    pictures = [_shrunk(annotated(folder, tracking, name, time), SHEET_WIDTH // len(names) - GAP) for name in names]
    if len(names) == 1:
        pictures = [annotated(folder, tracking, names[0], time)]
    write_bytes(path, _encoded(np.hstack([_framed(picture) for picture in pictures]), path))


def video(folder: Path, tracking: Tracking, camera: str, path: Path, width: int = 960, speed: float = 1.0) -> None:
    """All frames of a camera with their overlay, as WebM."""
    stamps = tracking.tracks[camera].stamp
    rate = (len(stamps) - 1) / (stamps[-1] - stamps[0]) * speed if len(stamps) > 1 else 1.0
    part, writer = path.with_name(f".{path.stem}.part{path.suffix}"), None
    try:
        for stamp in stamps:
            picture = _shrunk(annotated(folder, tracking, camera, stamp), width)
            picture = picture[: picture.shape[0] // 2 * 2, : picture.shape[1] // 2 * 2]
            if writer is None:
                size = (picture.shape[1], picture.shape[0])
                writer = cv2.VideoWriter(str(part), cv2.CAP_FFMPEG, cv2.VideoWriter.fourcc(*"VP80"), rate, size)
                if not writer.isOpened():
                    raise RenderError(f"{path}: this build of OpenCV cannot write WebM (VP8) there")
            writer.write(picture)
        if writer is not None:
            writer.release()
            _refuse_torn(part, len(stamps), path)
            part.replace(path)
    finally:
        part.unlink(missing_ok=True)


def _refuse_torn(part: Path, frames: int, path: Path) -> None:
    """OpenCV does not say when the disk is full: the file does."""
    video, found = cv2.VideoCapture(str(part)), 0
    while video.grab():
        found += 1
    if found < frames:
        raise RenderError(f"{path} cannot be written: {found} of {frames} frames arrived; is the disk full?")


def annotated(folder: Path, tracking: Tracking, camera: str, time: float) -> Array:
    """The frame of a camera nearest to a time, with plates as they were tracked and markers as they project."""
    track, place = tracking.tracks[camera], tracking.places[camera]
    frames = sorted((f for f in tracking.dataset.frames if f.camera == camera), key=lambda frame: frame.stamp)
    row = int(np.argmin(np.abs(track.stamp - time)))
    picture = _read(folder / frames[row].file)
    plates = {plate.name: plate for plate in tracking.dataset.plates}
    for k, name in enumerate(track.names):
        sighting = track.sighting(row, k)
        if sighting is not None:
            _outline(picture, sighting.corners(place.view.intrinsics, plates[name].size))
    nearest = int(np.argmin(np.abs(tracking.time - time)))
    for number, position in enumerate(tracking.positions.position[nearest]):
        _cross(picture, place.view, position, str(number + 1))
    return picture


def _outline(picture: Array, corners: Array) -> None:
    points = np.round(corners * 16).astype(np.int32)
    cv2.polylines(picture, [points], True, MEASURED, 2, cv2.LINE_AA, 4)


def _cross(picture: Array, view: View, position: Array, text: str) -> None:
    pixel = view.project(position)
    if not view.intrinsics.contains(pixel):
        return
    place = (round(float(pixel[0])), round(float(pixel[1])))
    cv2.drawMarker(picture, place, PROJECTED, cv2.MARKER_CROSS, 18, 2, cv2.LINE_AA)
    where = (place[0] + 8, place[1] - 16)
    cv2.putText(picture, text, where, cv2.FONT_HERSHEY_SIMPLEX, 0.7, PROJECTED, 2, cv2.LINE_AA)


def _read(path: Path) -> Array:
    picture: Any = cv2.imread(str(path))
    if picture is None:
        raise RenderError(f"{path} is missing or no picture")
    return np.asarray(picture)


def _shrunk(picture: Array, width: int) -> Array:
    height = round(picture.shape[0] * width / picture.shape[1])
    return cv2.resize(picture, (width, height), interpolation=cv2.INTER_AREA) if width < picture.shape[1] else picture


def _framed(picture: Array) -> Array:
    half = GAP // 2
    return cv2.copyMakeBorder(picture, half, half, half, half, cv2.BORDER_CONSTANT, value=(255, 255, 255))


def _encoded(picture: Array, path: Path) -> bytes:
    good, data = cv2.imencode(path.suffix, picture)
    if not good:
        raise RenderError(f"{path}: no such kind of picture")
    return data.tobytes()
