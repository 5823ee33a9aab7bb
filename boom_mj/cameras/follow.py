"""Plates followed through the pictures of one camera: prediction, alignment, loss, and finding them again by KAZE."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace

import cv2
import numpy as np

from boom_mj.cameras.align import Pattern, Sighting, align, facing
from boom_mj.cameras.intrinsics import Intrinsics
from boom_mj.cameras.recognise import Catalogue, recognise

Array = np.ndarray
KEPT = 0.78  # likeness from which a followed plate is still believed
JUMP = 6.0  # px by which a plate may leave its prediction
SEARCH = 20  # px around the prediction where a plate that slipped is looked for
PATIENCE = 10  # frames for which it is looked for there
LOOK_AGAIN, LOOK_EVERYWHERE = 10, 100  # frames between searches by KAZE: near where plates were lost, and in all
GROWTH = 15.0  # px per frame by which the window around a lost plate grows
SLENDER = 0.12  # least height over width of a plate's image, relative to the plate


@dataclass(frozen=True, eq=False)
class Track:
    """What one camera saw of the plates.

    Attributes:
        stamp: (n,), s.
        names: of the p plates.
        center: ideal points, (n, p, 2); NaN while hidden.
        slope: (n, p, 2, 2).
        likeness, deviation: (n, p); px.
    """

    stamp: Array
    names: tuple[str, ...]
    center: Array
    slope: Array
    likeness: Array
    deviation: Array

    def sighting(self, row: int, plate: int, normal: Array | None = None) -> Sighting | None:
        """The sighting of a plate in a frame, None while hidden; its normal faces the camera unless given."""
        center = self.center[row, plate]
        if not np.isfinite(center).all():
            return None
        normal = facing(center) if normal is None else normal
        return Sighting(center, self.slope[row, plate], normal, self.likeness[row, plate], self.deviation[row, plate])


@dataclass
class _Followed:
    """The state of one plate; mutable."""

    last: Sighting
    speed: Array = field(default_factory=lambda: np.zeros(2))  # ideal points per frame
    missing: int = 0

    def expected(self) -> Sighting:
        return replace(self.last, center=self.last.center + self.speed * (1 + self.missing))


Pictures = Iterable[Array]
Step = Callable[[], None]


def follow(
    pictures: Pictures, stamps: Array, lens: Intrinsics, catalogue: Catalogue, progress: Step = lambda: None
) -> Track:
    """Find and follow all plates of a catalogue.

    Args:
        pictures: grey levels, (h, w) uint8, in the order of the stamps.
    """
    patterns = {pattern.name: pattern for pattern in catalogue.patterns}
    track = _empty(stamps, tuple(patterns))
    state: dict[str, _Followed] = {}
    for row, picture in enumerate(pictures):
        levels = picture.astype(np.float32)
        for name, plate in state.items():
            sighting = _again(levels, lens, patterns[name], plate)
            if sighting is None:
                plate.missing += 1
            else:
                _note(plate, sighting)
        lost = {name: plate for name, plate in state.items() if plate.missing}
        wanted, window = set(), None
        if row % LOOK_EVERYWHERE == 0:
            wanted = set(patterns) - (set(state) - set(lost))
        elif lost and row % LOOK_AGAIN == 0:
            wanted, window = set(lost), _window(lost, lens)
        for name, sighting in recognise(picture, lens, catalogue, wanted, window).items() if wanted else ():
            if _plausible(sighting, patterns[name]):
                state[name] = _Followed(sighting)
        for name, plate in state.items():
            if not plate.missing:
                write(track, row, name, plate.last)
        progress()
    return track


def refine(
    pictures: Pictures, track: Track, lens: Intrinsics, patterns: Mapping[str, Pattern], normals: Array,
    progress: Step = lambda: None,
) -> Track:  # fmt: skip
    """The same sightings, aligned once more now that it is known where the plates face.

    Args:
        normals: of the plates in the camera frame, (n, p, 3); NaN where unknown.
    """
    better = _empty(track.stamp, track.names)
    for row, picture in enumerate(pictures):
        levels = picture.astype(np.float32)
        for k, name in enumerate(track.names):
            normal = normals[row, k]
            guess = track.sighting(row, k, normal if np.isfinite(normal).all() else None)
            found = align(levels, lens, patterns[name], guess) if guess is not None else None
            if found is not None and found.likeness >= KEPT and np.isfinite(found.deviation):
                write(better, row, name, found)
        progress()
    return better


def write(track: Track, row: int, name: str, sighting: Sighting) -> None:
    """Enter a sighting into a track."""
    k = track.names.index(name)
    track.center[row, k], track.slope[row, k] = sighting.center, sighting.slope
    track.likeness[row, k], track.deviation[row, k] = sighting.likeness, sighting.deviation


def _empty(stamps: Array, names: tuple[str, ...]) -> Track:
    shape = len(stamps), len(names)
    return Track(
        stamps,
        names,
        np.full((*shape, 2), np.nan),
        np.full((*shape, 2, 2), np.nan),
        np.zeros(shape),
        np.full(shape, np.nan),
    )


def _note(plate: _Followed, sighting: Sighting) -> None:
    """A plate was seen: its speed follows, unless it was away for long."""
    moved = (sighting.center - plate.last.center) / (1 + plate.missing)
    plate.speed = moved if plate.missing <= PATIENCE else np.zeros(2)
    plate.last, plate.missing = sighting, 0


def _again(levels: Array, lens: Intrinsics, pattern: Pattern, plate: _Followed) -> Sighting | None:
    """A plate at its prediction, or near it; None while hidden or away for too long."""
    if plate.missing > PATIENCE:
        return None
    expected = plate.expected()
    expected = replace(expected, normal=facing(expected.center))
    limit = JUMP * (1 + plate.missing)
    for propose in (lambda: expected, lambda: _searched(levels, lens, pattern, expected)):
        guess = propose()
        found = align(levels, lens, pattern, guess) if guess is not None else None
        if guess is None or found is None or found.likeness < KEPT or not np.isfinite(found.deviation):
            continue
        near = np.linalg.norm((found.center - guess.center) * lens.focal) < limit
        if near and _plausible(found, pattern) and _alike(found, plate.last):
            return found
    return None


def _searched(levels: Array, lens: Intrinsics, pattern: Pattern, expected: Sighting) -> Sighting | None:
    """The most similar place around a prediction, by correlation with the plate as it should look there."""
    corners = expected.corners(lens, pattern.size)
    if not np.isfinite(corners).all():
        return None
    low = np.floor(corners.min(axis=0)).astype(int)
    size = np.ceil(np.ptp(corners, axis=0)).astype(int) + 2
    start, stop = np.maximum(low - SEARCH, 0), np.minimum(low + size + SEARCH, [lens.width, lens.height])
    part = levels[start[1] : stop[1], start[0] : stop[0]]
    if size.min() < 4 or part.shape[0] <= size[1] or part.shape[1] <= size[0]:
        return None
    height, width = pattern.picture.shape
    source = np.array([(0, 0), (width, 0), (width, height), (0, height)], np.float32) - 0.5
    warp = cv2.getPerspectiveTransform(source, (corners - low).astype(np.float32))
    shrink = max(width / size[0], 1.0)
    smooth = cv2.GaussianBlur(pattern.picture, (0, 0), max(0.4 * shrink, 0.1)).astype(np.float32)
    face = cv2.warpPerspective(smooth, warp, tuple(size.tolist()), borderMode=cv2.BORDER_CONSTANT)
    mask = cv2.warpPerspective(np.ones_like(smooth), warp, tuple(size.tolist()))
    scores = cv2.matchTemplate(part, face, cv2.TM_CCOEFF_NORMED, mask=mask)
    scores[~np.isfinite(scores)] = -1
    _, _, _, best = cv2.minMaxLoc(scores)
    shift = np.array(best) + start - low
    return replace(expected, center=expected.center + shift / lens.focal)


def _plausible(sighting: Sighting, pattern: Pattern) -> bool:
    """Whether a sighting shows a plate from its front, and not a sliver of it."""
    image = sighting.slope * pattern.size
    stretch = np.linalg.svd(image, compute_uv=False)
    usual = min(pattern.size) / max(pattern.size)
    return bool(np.linalg.det(sighting.slope) < 0 and stretch[1] / stretch[0] > SLENDER * usual)


def _alike(a: Sighting, b: Sighting) -> bool:
    """Whether two sightings could be one plate a few frames apart: similar size and direction."""
    change = np.linalg.solve(b.slope, a.slope) - np.eye(2)
    return bool(np.abs(change).max() < 0.35)


def _window(lost: Mapping[str, _Followed], lens: Intrinsics) -> tuple[int, int, int, int] | None:
    """Where plates lost a while ago may be by now, px; None if that is everywhere."""
    low, high = np.full(2, np.inf), np.full(2, -np.inf)
    for plate in lost.values():
        place, reach = plate.last.pixel(lens), 60 + GROWTH * plate.missing
        low, high = np.minimum(low, place - reach), np.maximum(high, place + reach)
    low, high = np.maximum(low, 0).astype(int), np.minimum(high, [lens.width, lens.height]).astype(int)
    if (high - low).min() < 1:
        return None
    return int(low[0]), int(low[1]), int(high[0]), int(high[1])
