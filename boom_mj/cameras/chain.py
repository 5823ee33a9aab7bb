"""The measurement chain of the paper, from a folder of pictures to marker positions."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from boom_mj.cameras.align import Pattern
from boom_mj.cameras.backproject import Positions, back_project, right_hand
from boom_mj.cameras.calibrate import LensFit, PlacedCamera, calibrate_lens, place_camera
from boom_mj.cameras.dataset import Dataset, PlateEntry, read_dataset, read_picture
from boom_mj.cameras.follow import Track, follow, refine
from boom_mj.cameras.recognise import Catalogue, catalogue_of
from boom_mj.errors import DatasetError, TrackError
from boom_mj.recording import Recording, named_signal
from boom_mj.workers import worker_pool

Array = np.ndarray
FOR_PLACE = 5  # pictures from which a camera's place is taken
Say = Callable[[str], None]


@dataclass(frozen=True, eq=False)
class Tracking:
    """What came out of a folder of pictures.

    Attributes:
        time: of the positions, (n,), s.
        lenses, places, tracks: by camera.
    """

    dataset: Dataset
    lenses: dict[str, LensFit]
    places: dict[str, PlacedCamera]
    tracks: dict[str, Track]
    time: Array
    positions: Positions

    @property
    def recording(self) -> Recording:
        """The positions as /markers, NaN where hidden."""
        flat = self.positions.position.reshape(len(self.time), -1)
        signals = {"markers": named_signal("markers", self.time, flat)}
        text = f"markers seen by {', '.join(self.tracks)}: {self.dataset.description}"
        return Recording(self.dataset.name, self.dataset.machine, text, signals)

    @property
    def share(self) -> Array:
        """Share of the frames in which every marker has a position, (m,)."""
        return np.asarray(np.isfinite(self.positions.position).all(axis=2).mean(axis=0))


@dataclass(frozen=True)
class _Camera:
    """One camera's part of the work, ready to travel."""

    folder: Path
    dataset: Dataset
    name: str

    def pictures(self, rows: Array | None = None) -> Iterator[Array]:
        files = [frame.file for frame in self.frames]
        for row in range(len(files)) if rows is None else rows:
            yield self.read(files[row])

    @property
    def frames(self) -> list:
        return sorted((f for f in self.dataset.frames if f.camera == self.name), key=lambda f: f.stamp)

    @property
    def stamps(self) -> Array:
        return np.array([frame.stamp for frame in self.frames])

    def catalogue(self, markers: bool) -> Catalogue:
        plates = [p for p in self.dataset.plates if bool(p.marker) == markers]
        return catalogue_of([Pattern(p.name, read_picture(self.folder / p.picture), p.size) for p in plates])

    def read(self, file: str) -> Array:
        """A picture of this camera, (h, w) uint8."""
        camera = next(camera for camera in self.dataset.cameras if camera.name == self.name)
        picture = read_picture(self.folder / file)
        if picture.shape != (camera.height, camera.width):
            raise DatasetError(
                f"{self.folder / file} is {picture.shape[1]} x {picture.shape[0]} px; "
                f"pictures of {self.name} are {camera.width} x {camera.height}"
            )
        return picture


def track(folder: Path, workers: int = 1, say: Say = lambda text: None) -> Tracking:
    """Marker positions from a folder of pictures with its dataset.json.

    Raises:
        DatasetError: no such folder, cameras that move, files that are missing.
        TrackError: pictures from which nothing follows.
    """
    dataset = read_dataset(folder)
    _refuse(dataset, folder)
    jobs = [_Camera(folder, dataset, camera.name) for camera in dataset.cameras]
    names = [job.name for job in jobs]
    with worker_pool(min(workers, len(jobs))) as pool:
        lenses = dict(zip(names, pool.map(_lens, jobs)))
        say("lenses  " + ", ".join(f"{n} {fit.rms:.3f} px" for n, fit in lenses.items()))
        places = dict(zip(names, pool.map(_place, jobs, [lenses[n] for n in names])))
        say("places  " + ", ".join(f"{n} {p.rms:.3f} px of {len(p.plates)} plates" for n, p in places.items()))
        tracks = dict(zip(names, pool.map(_follow, jobs, [lenses[n] for n in names])))
        say("plates  " + ", ".join(f"{n} {_seen(t)}" for n, t in tracks.items()))
        time = jobs[0].stamps
        rough = _positions(dataset, places, tracks, time)
        turned = [partial(_refined, track=tracks[n], place=places[n], time=time, slewing=rough.slewing) for n in names]
        tracks = dict(zip(names, pool.map(_call, turned, jobs)))
    return Tracking(dataset, lenses, places, tracks, time, _positions(dataset, places, tracks, time))


def _refuse(dataset: Dataset, folder: Path) -> None:
    if not dataset.still:
        raise DatasetError(
            f"{folder}: its cameras stand elsewhere in every frame; tracking needs cameras that stand still"
        )
    for camera in dataset.cameras:
        if not any(picture.camera == camera.name for picture in dataset.calibration):
            raise DatasetError(f"{folder}: {camera.name} has no pictures of the chequerboard (calibration)")
        if not any(picture.camera == camera.name for picture in dataset.frames):
            raise DatasetError(f"{folder}: {camera.name} has no frames")
    if len(dataset.cameras) < 2:
        there = ", ".join(camera.name for camera in dataset.cameras) or "none"
        raise TrackError(f"{folder}: positions need two cameras; it has {there}")
    numbers = {plate.marker for plate in dataset.plates} - {0}
    if numbers != set(range(1, len(dataset.lateral) + 1)):
        raise DatasetError(f"{folder}: lateral holds {len(dataset.lateral)} markers, the plates {sorted(numbers)}")


def _lens(job: _Camera) -> LensFit:
    files = [picture.file for picture in job.dataset.calibration if picture.camera == job.name]
    pictures = [job.read(file) for file in files]
    return calibrate_lens(job.name, pictures, job.dataset.chequerboard)


def _place(job: _Camera, lens: LensFit) -> PlacedCamera:
    references = {plate.name: plate for plate in job.dataset.plates if not plate.marker}
    rows = np.unique(np.linspace(0, len(job.frames) - 1, FOR_PLACE).astype(int))
    return place_camera(job.name, list(job.pictures(rows)), lens.intrinsics, job.catalogue(False), references)


def _follow(job: _Camera, lens: LensFit) -> Track:
    return follow(job.pictures(), job.stamps, lens.intrinsics, job.catalogue(True))


def _refined(job: _Camera, track: Track, place: PlacedCamera, time: Array, slewing: Array) -> Track:
    known = np.isfinite(slewing)
    if not known.any():
        return track
    angle = np.interp(track.stamp, time[known], np.unwrap(slewing[known]))
    outward = right_hand(angle) @ place.view.rotation.T  # (n, 3), camera frame
    plates = {plate.name: plate for plate in job.dataset.plates}
    signs = np.array([_sign(plates[name]) for name in track.names])
    patterns = {pattern.name: pattern for pattern in job.catalogue(True).patterns}
    normals = outward[:, None, :] * signs[None, :, None]
    return refine(job.pictures(), track, place.view.intrinsics, patterns, normals)


def _call(function: Callable[[_Camera], Track], job: _Camera) -> Track:
    return function(job)


def _positions(dataset: Dataset, places: dict[str, PlacedCamera], tracks: dict[str, Track], time: Array) -> Positions:
    """Merge all cameras and both sides at the given times."""
    cameras, ideal, deviation, offset = [], [], [], []
    for name, found in tracks.items():
        for side in ("right", "left"):
            plates = {p.marker: p for p in dataset.plates if p.marker and p.side == side}
            columns = [
                found.names.index(plates[k + 1].name) if k + 1 in plates else -1 for k in range(len(dataset.lateral))
            ]
            cameras.append(places[name])
            ideal.append(_at(found.stamp, _columns(found.center, columns), time))
            deviation.append(_at(found.stamp, _columns(found.deviation, columns), time))
            offset.append(
                [_sign(plates[k + 1]) * plates[k + 1].offset if k + 1 in plates else 0.0 for k in range(len(columns))]
            )
    return back_project(cameras, ideal, deviation, np.array(offset), np.array(dataset.lateral))


def _columns(values: Array, columns: list[int]) -> Array:
    """Columns by number, NaN where the number is -1."""
    taken = values[:, columns].copy()
    taken[:, [k < 0 for k in columns]] = np.nan
    return taken


def _at(stamp: Array, values: Array, time: Array) -> Array:
    """Values between frames, linear; NaN beside a frame without a value, and beyond the frames."""
    right = np.clip(np.searchsorted(stamp, time - 1e-9), 1, max(len(stamp) - 1, 1))
    if len(stamp) == 1:
        return np.where(np.abs(time - stamp[0]).reshape(-1, *[1] * (values.ndim - 1)) < 1e-9, values[0], np.nan)
    before, after = stamp[right - 1], stamp[right]
    share = ((time - before) / (after - before)).reshape(-1, *[1] * (values.ndim - 1))
    with np.errstate(invalid="ignore"):
        mixed = (1 - share) * values[right - 1] + share * values[right]
    mixed = np.where(share < 1e-6, values[right - 1], np.where(share > 1 - 1e-6, values[right], mixed))
    return np.where((share > -1e-6) & (share < 1 + 1e-6), mixed, np.nan)


def _sign(plate: PlateEntry) -> float:
    return 1.0 if plate.side == "right" else -1.0


def _seen(track: Track) -> str:
    there = np.isfinite(track.center).all(axis=2)
    return f"{there.any(axis=0).sum()} of {there.shape[1]} seen, {there.sum(axis=1).mean():.1f} per frame"
