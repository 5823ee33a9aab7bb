"""Pictures one after the other as a video file, written whole or not at all."""

from collections.abc import Iterable
from pathlib import Path

import cv2
import numpy as np

from boom_mj.errors import RenderError

CODECS = {".webm": ("VP80", "WebM (VP8)"), ".mp4": ("mp4v", "MP4 (MPEG-4)")}


def write_video(path: Path, pictures: Iterable[np.ndarray], rate: float) -> None:
    """Write pictures, (h, w, 3) uint8 in OpenCV's order of colours, all of one size, at `rate` per second.

    Raises:
        RenderError: a format that OpenCV cannot write, or a file that is not whole.
    """
    code, kind = CODECS[path.suffix]
    part, writer, count = path.with_name(f".{path.stem}.part{path.suffix}"), None, 0
    try:
        for picture in pictures:
            even = picture[: picture.shape[0] // 2 * 2, : picture.shape[1] // 2 * 2]
            if writer is None:
                size = (even.shape[1], even.shape[0])
                writer = cv2.VideoWriter(str(part), cv2.CAP_FFMPEG, cv2.VideoWriter.fourcc(*code), rate, size)
                if not writer.isOpened():
                    raise RenderError(f"{path}: this build of OpenCV cannot write {kind} there")
            writer.write(even)
            count += 1
        if writer is not None:
            writer.release()
            _refuse_torn(part, count, path)
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
