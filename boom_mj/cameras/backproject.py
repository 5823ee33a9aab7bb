"""From pixels back to markers (33): the point that fits every camera best, both sides merged by their plates' offsets.

    min_p  sum_k |z_k - P_k(p + p_off,k)|^2 / sigma_k^2,      p_off = +-offset (sin q1, -cos q1, 0)

with the right-hand normal of the boom's plane at the slewing angle q1. The slewing angle is that at which the markers
lie at their known lateral distances from the plane. Sightings that contradict the others are left out; where it cannot
be told which of two is wrong, or a marker is seen by one camera only, there is no position.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from boom_mj.cameras.calibrate import PlacedCamera, pose_slope

Array = np.ndarray
CONTRADICTION = 2.5  # px, of a sighting that does not fit the others
MODEL = 0.05  # px: what lens and plate leave unexplained
VAGUE = 0.2  # m, standard deviation from which a position says nothing
MODEL_LATERAL = 0.01  # m: by how far a bending boom leaves its plane
SINGULAR = 1e-3  # px^2/m^2, added to information that is missing
ROUNDS, ANGLE_ROUNDS = 8, 4


@dataclass(frozen=True, eq=False)
class Positions:
    """Markers in the world.

    Attributes:
        position: (n, m, 3), m; NaN where a marker is hidden or contradictory.
        covariance: (n, m, 3, 3), m^2; NaN there.
        cameras: that agree on it, (n, m).
        slewing: q1 in every frame, (n,), rad; NaN where too few markers are seen.
        contradictory: positions refused because their two sightings disagree.
    """

    position: Array
    covariance: Array
    cameras: Array
    slewing: Array
    contradictory: int


def back_project(
    cameras: Sequence[PlacedCamera], ideal: Sequence[Array], deviation: Sequence[Array], offset: Array, lateral: Array
) -> Positions:
    """Positions of m markers in n frames.

    Args:
        ideal: per camera and side of the boom, ideal points of the plates, (n, m, 2); NaN while hidden.
        deviation: of them, (n, m), px.
        offset: of the plates to the right, per camera and side, (k, m), m: negative on the left.
        lateral: of the markers to the right of the boom's plane, (m,), m.
    """
    points, spread = np.stack(ideal), np.sqrt(np.stack(deviation) ** 2 + MODEL**2)
    use = np.isfinite(points).all(axis=-1)  # (k, n, m)
    slewing, known = _turned(cameras, points, spread, use, offset, lateral)
    residual = _solved(cameras, points, spread, use, offset, known)[1]
    use, contradictory = _agreeing(cameras, points, spread, use, offset, known, residual)
    slewing, known = _turned(cameras, points, spread, use, offset, lateral)
    position, _, spreads = _solved(cameras, points, spread, use, offset, known)
    vague = ~(np.sqrt(np.trace(spreads, axis1=-2, axis2=-1)) < VAGUE)
    position[vague], spreads[vague] = np.nan, np.nan
    return Positions(position, spreads, use.sum(axis=0), slewing, contradictory)


def _turned(
    cameras: Sequence[PlacedCamera], points: Array, spread: Array, use: Array, offset: Array, lateral: Array
) -> tuple[Array, Array]:
    """q1 in every frame, NaN where unknown, and the same with the last guess there, (n,) each."""
    known = np.zeros(points.shape[1])
    for _ in range(ANGLE_ROUNDS):
        position, _, covariance = _solved(cameras, points, spread, use, offset, known)
        slewing = _slewing(position, covariance, lateral, cameras, use, offset)
        known = np.where(np.isfinite(slewing), slewing, known)
    return slewing, known


def right_hand(slewing: Array) -> Array:
    """Normal of the boom's plane, (..., 3)."""
    return np.stack([np.sin(slewing), -np.cos(slewing), np.zeros_like(slewing)], axis=-1)


def _solved(
    cameras: Sequence[PlacedCamera], points: Array, spread: Array, use: Array, offset: Array, slewing: Array
) -> tuple[Array, Array, Array]:
    """Gauss-Newton on (33) for all markers and frames at once: positions, residuals in px (k, n, m), covariances."""
    shift = offset[:, None, :, None] * right_hand(slewing)[None, :, None, :]  # (k, n, m, 3)
    position = _nearest_to_rays(cameras, points, use, shift)
    enough = use.sum(axis=0) > 1
    for round_ in range(ROUNDS + 1):
        normal, right, rest = np.zeros((*enough.shape, 3, 3)), np.zeros((*enough.shape, 3)), []
        noise = np.zeros((*enough.shape, 3, 3))
        for camera, seen, sigma, there, off in zip(cameras, points, spread, use, shift):
            focal = np.array(camera.view.intrinsics.focal)
            inside = camera.view.in_camera(position + off)
            depth = inside[..., 2:]
            with np.errstate(invalid="ignore", divide="ignore"):
                difference = (seen - inside[..., :2] / depth) * focal  # (n, m, 2)
                by = _by_point(inside, focal) @ camera.view.rotation  # (n, m, 2, 3)
            weight = np.where(there, 1 / sigma**2, 0.0)
            by, difference = np.nan_to_num(by), np.nan_to_num(difference)
            normal += np.einsum("nm,nmia,nmib->nmab", weight, by, by)
            right += np.einsum("nm,nmia,nmi->nma", weight, by, difference)
            rest.append(np.where(there, np.linalg.norm(difference, axis=-1), np.nan))
            if round_ == ROUNDS:  # what the camera's own place leaves open is the same for all its sightings
                slope = pose_slope(np.nan_to_num(inside, nan=1.0).reshape(-1, 3), focal).reshape(*enough.shape, 2, 6)
                pull = np.einsum("nm,nmia,nmij->nmaj", weight, by, slope)
                noise += pull @ camera.covariance @ np.swapaxes(pull, -1, -2)
        inverse = np.linalg.inv(np.where(enough[..., None, None], normal + SINGULAR * np.eye(3), np.eye(3)))
        if round_ < ROUNDS:
            position = position + np.einsum("nmab,nmb->nma", inverse, right)
    covariance = inverse + inverse @ noise @ inverse
    gone = ~enough
    position[gone], covariance[gone] = np.nan, np.nan
    return position, np.stack(rest), covariance


def _nearest_to_rays(cameras: Sequence[PlacedCamera], points: Array, use: Array, shift: Array) -> Array:
    """Points nearest to all rays of their sightings, (n, m, 3), m."""
    normal, right = np.zeros((*use.shape[1:], 3, 3)), np.zeros((*use.shape[1:], 3))
    for camera, seen, there, off in zip(cameras, points, use, shift):
        ray = np.concatenate([seen, np.ones_like(seen[..., :1])], axis=-1) @ camera.view.rotation
        ray = np.nan_to_num(ray / np.linalg.norm(ray, axis=-1, keepdims=True))
        across = np.eye(3) - ray[..., :, None] * ray[..., None, :]
        across[~there] = 0.0
        normal += across
        right += np.einsum("nmab,nmb->nma", across, camera.view.position - off)
    return np.einsum("nmab,nmb->nma", np.linalg.inv(normal + 1e-9 * np.eye(3)), right)


def _by_point(inside: Array, focal: Array) -> Array:
    """Derivative of ideal pixels by the camera point, (..., 2, 3)."""
    x, y, z = np.moveaxis(inside, -1, 0)
    zero = np.zeros_like(x)
    rows = np.stack([np.stack([1 / z, zero, -x / z**2], -1), np.stack([zero, 1 / z, -y / z**2], -1)], -2)
    return rows * focal[:, None]


def _slewing(
    position: Array, covariance: Array, lateral: Array, cameras: Sequence[PlacedCamera], use: Array, offset: Array
) -> Array:
    """q1 at which right_hand(q1) . p = lateral in the least squares sense, (n,), rad; NaN with less than 2 markers.

    Weighted: a marker between opposite cameras may be metres off along the normal.
    """
    found = np.full(len(position), np.nan)
    for row, points in enumerate(position):
        there = np.isfinite(points).all(axis=1)
        if there.sum() < 2:
            continue
        p, aside = points[there], lateral[there]
        far = p[np.argmax(np.hypot(p[:, 0], p[:, 1]))]
        starts = np.arctan2(far[1], far[0]) + np.array([0.0, np.pi])
        angle = max(starts, key=lambda q: _facing(q, points, cameras, use[:, row], offset))
        for _ in range(10):
            normal = right_hand(np.array(angle))
            away = p @ normal - aside
            by = p @ np.array([np.cos(angle), np.sin(angle), 0.0])
            weight = 1 / (normal @ covariance[row, there] @ normal + MODEL_LATERAL**2)
            step = -(weight * by @ away) / max(weight * by @ by, 1e-9)
            angle = angle + step
        found[row] = (angle + np.pi) % (2 * np.pi) - np.pi
    return found


def _facing(angle: float, points: Array, cameras: Sequence[PlacedCamera], use: Array, offset: Array) -> float:
    """How many sightings see the front of their plate if the boom points that way."""
    normal = right_hand(np.array(angle))
    score = 0.0
    for camera, there, off in zip(cameras, use, offset):
        toward = (camera.view.position - points) @ normal * np.sign(off)
        score += float(np.sum(there & (toward > 0))) - float(np.sum(there & (toward < 0)))
    return score


def _agreeing(
    cameras: Sequence[PlacedCamera],
    points: Array,
    spread: Array,
    use: Array,
    offset: Array,
    slewing: Array,
    residual: Array,
) -> tuple[Array, int]:
    """Sightings without those that contradict the rest, and how many positions are refused for want of a majority."""
    use = use.copy()
    wrong = (np.nanmax(np.where(use, residual, 0.0), axis=0) > CONTRADICTION) & (use.sum(axis=0) > 1)
    undecided = wrong & (use.sum(axis=0) == 2)
    use[:, undecided] = False
    refused = int(undecided.sum())
    for row, marker in np.argwhere(wrong & ~undecided):
        cell = np.ix_(range(len(cameras)), [row], [marker])
        best, least = None, np.inf
        for left_out in np.flatnonzero(use[:, row, marker]):
            trial = use[cell].copy()
            trial[left_out] = False
            rest = _solved(cameras, points[cell], spread[cell], trial, offset[:, [marker]], slewing[[row]])[1]
            if (worst := float(np.max(rest[trial]))) < least:
                best, least = trial[:, 0, 0], worst
        use[:, row, marker] = best if best is not None and least <= CONTRADICTION else False
        refused += not use[:, row, marker].any()
    return use, refused
