"""What the lenses do, from a chequerboard, and where the cameras are, from the reference plates on the truck."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from boom_mj.cameras.align import Pattern, Sighting, align
from boom_mj.cameras.chequerboard import object_points
from boom_mj.cameras.dataset import PlateEntry
from boom_mj.cameras.intrinsics import Intrinsics
from boom_mj.cameras.recognise import RECOGNISED, Catalogue, recognise
from boom_mj.cameras.view import View
from boom_mj.errors import TrackError
from boom_mj.machine.rig import Chequerboard

Array = np.ndarray
LEAST_BOARDS, LEAST_PLATES = 5, 4
ENOUGH = 2  # plates, all of whose corners count, for a first pose; LEAST_PLATES must then be where it says
ROUGH = 8.0  # px, of a pose from features alone
PRECISE = 3.0  # times the median residual beyond which a reference plate is left out
FLOOR = 0.02  # px, that an alignment is at best


@dataclass(frozen=True, eq=False)
class LensFit:
    """Intrinsics and the root mean square of their residuals over `boards` pictures, px."""

    intrinsics: Intrinsics
    rms: float
    boards: int


@dataclass(frozen=True, eq=False)
class PlacedCamera:
    """A camera whose place is known.

    Attributes:
        view: (32).
        covariance: of a small rotation (camera frame, rad) and the translation of camera_from_world (m), (6, 6).
        rms: of the residuals of its reference plates, px.
        plates: their names.
    """

    view: View
    covariance: Array
    rms: float
    plates: tuple[str, ...]


def calibrate_lens(name: str, pictures: Sequence[Array], board: Chequerboard) -> LensFit:
    """Intrinsics from pictures of a chequerboard, (h, w) uint8.

    Raises:
        TrackError: the board was found in too few of them.
    """
    where, plan = [], object_points(board).astype(np.float32)
    for picture in pictures:
        found, corners = cv2.findChessboardCornersSB(picture, board.corners, flags=cv2.CALIB_CB_EXHAUSTIVE)
        if found:
            where.append(_sharpened(picture, corners, board))
    if len(where) < LEAST_BOARDS:
        raise TrackError(
            f"{name}: the chequerboard of {board.corners[0]} x {board.corners[1]} inner corners was found in "
            f"{len(where)} of {len(pictures)} pictures; its lens needs {LEAST_BOARDS}"
        )
    height, width = pictures[0].shape
    rms, matrix, distortion, _, _ = cv2.calibrateCamera([plan] * len(where), where, (width, height), None, None)
    k = [float(value) for value in distortion.ravel()[:5]]
    focal, center = (float(matrix[0, 0]), float(matrix[1, 1])), (float(matrix[0, 2]), float(matrix[1, 2]))
    return LensFit(Intrinsics(width, height, focal, center, (k[0], k[1], k[2], k[3], k[4])), float(rms), len(where))


def _sharpened(picture: Array, corners: Array, board: Chequerboard) -> Array:
    """Corners refined within a third of a square."""
    grid = corners.reshape(board.corners[1], board.corners[0], 2)
    nearest = min(np.linalg.norm(np.diff(grid, axis=axis), axis=-1).min() for axis in (0, 1))
    half = int(np.clip(nearest / 3, 2, 10))
    stop = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_COUNT, 100, 1e-4)
    return cv2.cornerSubPix(picture, corners.astype(np.float32), (half, half), (-1, -1), stop)


def place_camera(
    name: str, pictures: Sequence[Array], lens: Intrinsics, catalogue: Catalogue, references: Mapping[str, PlateEntry]
) -> PlacedCamera:
    """The pose of a camera from the reference plates in some of its pictures, (h, w) uint8.

    Plates are recognised in the first picture that shows enough of them; that pose predicts all plates in all pictures,
    where they are aligned with the direction they face; the pose of their mean places is the result.

    Raises:
        TrackError: no picture shows enough of the plates, or they contradict each other.
    """
    best: dict[str, Sighting] = {}
    for picture in pictures:
        found = recognise(picture, lens, catalogue, set(references), None)
        best = found if len(found) > len(best) else best
        if len(best) > LEAST_PLATES:
            break
    if len(best) < ENOUGH:
        raise TrackError(
            f"{name}: its place needs {ENOUGH} of the reference plates {', '.join(references)}; "
            f"found {', '.join(sorted(best)) or 'none'}"
        )
    rotation, translation = _first_pose(name, best, references)
    patterns = {pattern.name: pattern for pattern in catalogue.patterns}
    for _ in range(3):
        seen = _aligned(pictures, lens, patterns, references, rotation, translation)
        if len(seen) < LEAST_PLATES:
            raise TrackError(
                f"{name}: only {len(seen)} reference plates are where its place says; it needs {LEAST_PLATES}"
            )
        rotation, translation, residuals, covariance = _fitted(seen, references, lens, rotation, translation)
        size = np.linalg.norm(residuals, axis=1)
        seen = {n: s for n, s, r in zip(seen, seen.values(), size) if r <= max(PRECISE * np.median(size), 3 * FLOOR)}
        if len(seen) >= LEAST_PLATES:
            rotation, translation, residuals, covariance = _fitted(seen, references, lens, rotation, translation)
    view = View(lens, rotation, -rotation.T @ translation)
    return PlacedCamera(view, covariance, float(np.sqrt(np.mean(residuals**2))), tuple(seen))


def _first_pose(name: str, found: Mapping[str, Sighting], references: Mapping[str, PlateEntry]) -> tuple[Array, Array]:
    """Pose from a few plates of which some may be wrong: all four corners of each count."""
    world = np.concatenate([_corners(references[plate]) for plate in found]).astype(np.float64)
    ideal = np.concatenate([s.points(_flat_corners(references[plate])) for plate, s in found.items()])
    good, turn, shift, inliers = cv2.solvePnPRansac(
        world, ideal, np.eye(3), None, reprojectionError=ROUGH / 1000, iterationsCount=300, flags=cv2.SOLVEPNP_SQPNP
    )
    if not good or len(inliers) < 2 * ENOUGH:
        raise TrackError(f"{name}: the reference plates {', '.join(found)} contradict each other")
    turn, shift = cv2.solvePnPRefineLM(world[inliers[:, 0]], ideal[inliers[:, 0]], np.eye(3), None, turn, shift)
    return cv2.Rodrigues(turn)[0], shift.ravel()


def _aligned(
    pictures: Sequence[Array], lens: Intrinsics, patterns: Mapping[str, Pattern], references: Mapping[str, PlateEntry],
    rotation: Array, translation: Array,
) -> dict[str, Array]:  # fmt: skip
    """Ideal points of the reference plates that face the camera: medians over the pictures, (2,)."""
    found: dict[str, list[Array]] = {}
    for picture in pictures:
        levels = picture.astype(np.float32)
        for name, plate in references.items():
            guess = predicted(plate, rotation, translation)
            sighting = align(levels, lens, patterns[name], guess) if guess is not None else None
            if sighting is not None and sighting.likeness >= RECOGNISED and np.isfinite(sighting.deviation):
                found.setdefault(name, []).append(sighting.center)
    return {name: np.median(centers, axis=0) for name, centers in found.items()}


def predicted(plate: PlateEntry, rotation: Array, translation: Array) -> Sighting | None:
    """How a reference plate must look; None if it faces away."""
    right, up = rotation @ plate.right, rotation @ plate.up
    center, normal = rotation @ plate.center + translation, np.cross(right, up)
    if center[2] <= 0 or normal @ center >= 0:
        return None
    ideal = center[:2] / center[2]
    slope = np.column_stack([(axis[:2] - ideal * axis[2]) / center[2] for axis in (right, up)])
    return Sighting(ideal, slope, normal)


def _fitted(
    seen: Mapping[str, Array],
    references: Mapping[str, PlateEntry],
    lens: Intrinsics,
    rotation: Array,
    translation: Array,
) -> tuple[Array, Array, Array, Array]:
    """Pose that fits plate centres best: rotation, translation, residuals (n, 2) px, covariance (6, 6)."""
    world = np.array([references[name].center for name in seen])
    ideal, focal = np.array(list(seen.values())), np.array(lens.focal)
    for _ in range(20):
        points = world @ rotation.T + translation
        residuals = (ideal - points[:, :2] / points[:, 2:]) * focal
        by = pose_slope(points, focal)  # (n, 2, 6)
        flat = by.reshape(-1, 6)
        step = np.linalg.lstsq(flat, residuals.ravel(), rcond=None)[0]
        turn = cv2.Rodrigues(step[:3])[0]
        rotation, translation = turn @ rotation, turn @ translation + step[3:]
        if np.abs(step).max() < 1e-10:
            break
    noise = max(float(residuals.ravel() @ residuals.ravel()) / max(2 * len(world) - 6, 1), FLOOR**2)
    return rotation, translation, residuals, noise * np.linalg.inv(flat.T @ flat)


def pose_slope(points: Array, focal: Array) -> Array:
    """Derivative of the pixels of camera points (n, 3) by a rotation about the camera and a shift, (n, 2, 6)."""
    x, y, z = points.T
    zero = np.zeros_like(x)
    by_point = np.stack([np.stack([1 / z, zero, -x / z**2], -1), np.stack([zero, 1 / z, -y / z**2], -1)], 1)
    turned = np.stack([np.stack([zero, z, -y], -1), np.stack([-z, zero, x], -1), np.stack([y, -x, zero], -1)], 1)
    return np.concatenate([by_point @ turned, by_point], axis=2) * np.asarray(focal)[None, :, None]


def _flat_corners(plate: PlateEntry) -> Array:
    return np.array([(-0.5, 0.5), (0.5, 0.5), (0.5, -0.5), (-0.5, -0.5)]) * plate.size


def _corners(plate: PlateEntry) -> Array:
    """World places of a reference plate's corners, (4, 3), m."""
    return np.asarray(plate.center + _flat_corners(plate) @ np.array([plate.right, plate.up]))
