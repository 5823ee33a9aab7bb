"""A data set frame by frame, by several processes, resumable: whatever has its label is done."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import cv2
import numpy as np

from boom_mj.cameras.chequerboard import shoot_boards
from boom_mj.cameras.dataset import DEPTH_UNIT, write_json
from boom_mj.cameras.exposure import expose, instants, noisy
from boom_mj.cameras.film import Film
from boom_mj.cameras.intrinsics import Intrinsics
from boom_mj.cameras.labels import label
from boom_mj.cameras.light import weather_of
from boom_mj.cameras.studio import Studio, choose_headless
from boom_mj.files import write_bytes
from boom_mj.machine.rig import Chequerboard
from boom_mj.spreading import results

Array = np.ndarray
Report = Callable[[int, int], None]
"""Told how many of how many frames are done."""
BATCH = 4  # frames that a worker takes at once
FARTHEST = 65535  # grey level of a 16 bit picture


@dataclass(frozen=True)
class Look:
    """How pictures are made.

    Attributes:
        suffix: ".png", or ".jpg" with a quality in percent.
        depth, masks: whether to write them.
        blur: instants within the exposure; 1 is sharp.
        bands: of rows with their own time; 1 is a global shutter.
        noise: whether the sensors add theirs.
        randomise: what is drawn anew for every frame, among light, texture and pose.
    """

    suffix: str = ".png"
    quality: int = 95
    depth: bool = False
    masks: bool = False
    blur: int = 1
    bands: int = 1
    noise: bool = False
    randomise: frozenset[str] = frozenset()
    seed: int = 0

    def encode(self, picture: Array) -> bytes:
        """The file's bytes of a picture, red green blue."""
        options = (
            [cv2.IMWRITE_JPEG_QUALITY, self.quality] if self.suffix == ".jpg" else [cv2.IMWRITE_PNG_COMPRESSION, 3]
        )
        return cv2.imencode(self.suffix, picture[..., ::-1], options)[1].tobytes()


@dataclass(frozen=True)
class Frame:
    """One picture to take: the `number`th of a camera, at a true time, s."""

    camera: str
    number: int
    stamp: float
    time: float

    def place(self, kind: str, suffix: str) -> str:
        """Its file of a kind, relative to the data set."""
        return f"{kind}/{self.camera}/{self.number:06d}{suffix}"


@dataclass(frozen=True)
class Batch:
    """Frames that a process takes at once."""

    frames: tuple[Frame, ...]

    def __str__(self) -> str:
        first, last = (self.frames[k].place("images", "") for k in (0, -1))
        return f"{first} to {last}"


def frames_of(film: Film, start: float, stop: float, every: int) -> list[Frame]:
    """The frames that the cameras take from start to stop (s, their clocks), each `every`th one; ordered in time."""
    frames = []
    for camera in film.rig:
        rate, offset = camera.file.frame_rate_hz / every, camera.file.clock_offset
        for number in range(int(np.floor((stop - start) * rate + 1e-9)) + 1):
            stamp = start + number / rate
            frames.append(Frame(camera.name, number, round(stamp, 9), round(stamp - offset, 9)))
    return sorted(frames, key=lambda frame: (frame.number, frame.camera))


def shoot(studio: Studio, frame: Frame, look: Look, folder: Path) -> None:
    """Take one frame: picture, depth and masks if wanted, and its label last."""
    camera = studio.rig[frame.camera]
    weather = weather_of(frame.number, look.randomise, look.seed, tuple(studio.rig))
    if look.randomise:
        studio.set_weather(weather)

    def picture_at(shift: float) -> Array:
        studio.pose(frame.time + shift)
        return studio.picture(frame.camera)

    picture = expose(picture_at, instants(camera.file, look.blur, look.bands))
    if look.noise:
        rng = np.random.default_rng((look.seed, 1, sorted(studio.rig).index(frame.camera), frame.number))
        picture = noisy(picture, camera.file, rng)
    write_bytes(folder / frame.place("images", look.suffix), look.encode(picture))
    studio.pose(frame.time)
    if look.depth:
        depth = np.round(studio.depth(frame.camera) / DEPTH_UNIT)
        write_bytes(folder / frame.place("depth", ".png"), _png(np.where(depth > FARTHEST, 0, depth).astype(np.uint16)))
    if look.masks:
        write_bytes(folder / frame.place("masks", ".png"), _png(studio.bodies(frame.camera)))
    known = {"number": frame.number, "stamp": frame.stamp, "time": frame.time}
    found = label(studio, frame.camera, studio.view(frame.camera, weather))
    write_json(folder / frame.place("labels", ".json"), {**known, **found})


def missing_frames(frames: list[Frame], folder: Path) -> list[Frame]:
    """Those that have no label in a folder."""
    return [frame for frame in frames if not (folder / frame.place("labels", ".json")).is_file()]


def render_frames(
    film: Film, frames: list[Frame], look: Look, folder: Path, report: Report, jobs: int = 1, cluster: str | None = None
) -> None:
    """Take all frames that are not done yet; for `jobs` and `cluster` see `spread`.

    Raises:
        RenderError: no OpenGL.
        OutputError: a full disk.
        WorkerError: frames that no process survives, when all others are done. What is done stays.
    """
    missing = missing_frames(frames, folder)
    batches = [Batch(tuple(missing[k : k + BATCH])) for k in range(0, len(missing), BATCH)]
    done = len(frames) - len(missing)
    report(done, len(frames))
    choose_headless()
    work = partial(_shoot_all, film=film, look=look, folder=folder.resolve())
    for batch, _ in results(work, batches, jobs, cluster):
        done += len(batch.frames)
        report(done, len(frames))


def render_boards(
    film: Film, board: Chequerboard, files: Mapping[str, list[Path]], jobs: int = 1, cluster: str | None = None
) -> None:
    """Pictures of the chequerboard for the cameras whose files are not all there."""
    lenses = {camera.name: camera.view.intrinsics for camera in film.rig}
    missing = {name: [p.resolve() for p in paths] for name, paths in files.items() if not all(map(Path.is_file, paths))}
    choose_headless()
    work = partial(_shoot_boards, lenses=lenses, board=board, files=missing)
    for _ in results(work, missing, jobs, cluster):
        pass


def _shoot_all(batch: Batch, film: Film, look: Look, folder: Path) -> None:
    cv2.setNumThreads(1)
    studio = _own_studio(film)
    for frame in batch.frames:
        shoot(studio, frame, look, folder)


def _shoot_boards(
    camera: str, lenses: Mapping[str, Intrinsics], board: Chequerboard, files: Mapping[str, list[Path]]
) -> None:
    cv2.setNumThreads(1)
    for path, picture in zip(files[camera], shoot_boards(lenses[camera], board), strict=True):
        write_bytes(path, _png(cv2.cvtColor(picture, cv2.COLOR_RGB2GRAY)))


_studio: list[Studio] = []  # of this process: the one of the film that it shot last


def _own_studio(film: Film) -> Studio:
    if not _studio or _studio[0].film is not film:
        while _studio:
            _studio.pop().__exit__()
        _studio.append(Studio(film))
    return _studio[0]


def _png(picture: Array) -> bytes:
    return cv2.imencode(".png", picture, [cv2.IMWRITE_PNG_COMPRESSION, 3])[1].tobytes()
