"""Which plates a picture shows, and roughly where: KAZE features of the plates' pictures, found again."""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from boom_mj.cameras.align import Pattern, Sighting, align, facing
from boom_mj.cameras.intrinsics import Intrinsics
from boom_mj.errors import TrackError

Array = np.ndarray
PLATE_PIXELS, RIM, SURROUNDINGS = 128, 28, 150  # along a plate, for its own features; px and grey level around it
THRESHOLD = 5e-4  # of KAZE's detector
WORTH = 20.0  # standard deviation of grey levels within WINDOW that a plate's blobs reach
WINDOW, THICKEST_EDGE = 9, 13  # px; a band of contrast no wider than this is an edge, not a plate
MARGIN = 10  # px around a region
LONGEST, OVERLAP = 120, 48  # px of a region, and of its neighbour that it shares
ENLARGED = (1.0, 3.0)  # for plates of about 130 px and 40 px
DISTINCT = 0.92  # distance to the best plate over that to the best of the others
AGREEING = 3  # matches that must agree on one place
TOLERANCE = 2.0  # px, between matches that agree
MILLI = 1000.0
RECOGNISED = 0.8  # likeness from which a plate is believed


@dataclass(frozen=True, eq=False)
class Catalogue:
    """Features of all plates: places on the plate, (n, 2) m, descriptors, (n, 64), and whose they are, (n,)."""

    patterns: tuple[Pattern, ...]
    places: Array
    descriptors: Array
    owners: Array


def catalogue_of(patterns: Sequence[Pattern]) -> Catalogue:
    """KAZE features of plates.

    Raises:
        TrackError: none of them has any.
    """
    kaze, places, descriptors, owners = cv2.KAZE.create(threshold=THRESHOLD), [], [], []
    for k, pattern in enumerate(patterns):
        columns = PLATE_PIXELS
        rows = max(8, round(columns * pattern.size[1] / pattern.size[0]))
        small = cv2.resize(pattern.picture, (columns, rows), interpolation=cv2.INTER_AREA)
        framed = cv2.copyMakeBorder(small, RIM, RIM, RIM, RIM, cv2.BORDER_CONSTANT, value=SURROUNDINGS)
        points, found = kaze.detectAndCompute(framed, None)
        share = (np.reshape([point.pt for point in points], (-1, 2)) - RIM + 0.5) / [columns, rows]
        own = ((share > 0) & (share < 1)).all(axis=1)
        if not own.any():
            continue
        places.append((share[own] - 0.5) * [pattern.size[0], -pattern.size[1]])
        descriptors.append(found[own])
        owners.append(np.full(own.sum(), k))
    if not places:
        raise TrackError(f"no plate of {', '.join(pattern.name for pattern in patterns) or 'none'} can be recognised")
    return Catalogue(tuple(patterns), np.concatenate(places), np.concatenate(descriptors), np.concatenate(owners))


def recognise(
    picture: Array, lens: Intrinsics, catalogue: Catalogue, wanted: set[str], window: tuple[int, int, int, int] | None
) -> dict[str, Sighting]:
    """The wanted plates that a picture shows, aligned.

    Args:
        picture: grey levels, (h, w) uint8.
        window: left, upper, right, lower limits of the search, px; None for all of the picture.
    """
    found: dict[str, Sighting] = {}
    levels = picture.astype(np.float32)
    for region in _regions(picture, window or (0, 0, lens.width, lens.height)):
        pixels, descriptors = _features(picture, region)
        if len(pixels) < AGREEING:
            continue
        distances = _distances(descriptors, catalogue.descriptors)  # (features, entries)
        for k, pattern in enumerate(catalogue.patterns):
            if pattern.name not in wanted or pattern.name in found:
                continue
            own = catalogue.owners == k
            nearest, others = distances[:, own].min(axis=1), distances[:, ~own].min(axis=1, initial=np.inf)
            rows = np.flatnonzero(nearest < DISTINCT * others)
            if len(rows) < AGREEING:
                continue
            entries = np.flatnonzero(own)[distances[np.ix_(rows, own)].argmin(axis=1)]
            sighting = _placed(catalogue.places[entries], pixels[rows], lens, levels, pattern)
            if sighting is not None:
                found[pattern.name] = sighting
    return found


def _regions(picture: Array, window: tuple[int, int, int, int]) -> list[tuple[int, int, int, int]]:
    """Where a picture is as full of contrast as a plate is: left, upper, right, lower limits, px."""
    left, upper, right, lower = window
    part = picture[upper:lower, left:right].astype(np.float32)
    if min(part.shape) < WINDOW:
        return []
    mean, square = (cv2.blur(values, (WINDOW, WINDOW)) for values in (part, part * part))
    busy = (square - mean**2 > WORTH**2).astype(np.uint8)
    rich = cv2.morphologyEx(busy, cv2.MORPH_OPEN, np.ones((THICKEST_EDGE, THICKEST_EDGE), np.uint8))
    _, _, boxes, _ = cv2.connectedComponentsWithStats(rich)
    regions = []
    for x, y, width, height, _ in boxes[1:]:
        for start in range(x, max(x + width - OVERLAP, x + 1), LONGEST - OVERLAP):
            for top in range(y, max(y + height - OVERLAP, y + 1), LONGEST - OVERLAP):
                stop, bottom = min(x + width, start + LONGEST), min(y + height, top + LONGEST)
                if not rich[top:bottom, start:stop].any():
                    continue
                low = max(start - MARGIN, 0) + left, max(top - MARGIN, 0) + upper
                high = min(stop + MARGIN + left, right), min(bottom + MARGIN + upper, lower)
                regions.append((int(low[0]), int(low[1]), int(high[0]), int(high[1])))
    return regions


def _features(picture: Array, region: tuple[int, int, int, int]) -> tuple[Array, Array]:
    """Pixels (n, 2) and descriptors (n, 64) of KAZE features within a region."""
    left, upper, right, lower = region
    part = picture[upper:lower, left:right]
    pixels, descriptors = [], []
    for factor in ENLARGED:
        large = cv2.resize(part, None, fx=factor, fy=factor, interpolation=cv2.INTER_CUBIC)
        points, found = cv2.KAZE.create(threshold=THRESHOLD).detectAndCompute(large, None)
        if len(points):
            pixels.append((np.array([point.pt for point in points]) + 0.5) / factor - 0.5 + [left, upper])
            descriptors.append(found)
    if not pixels:
        return np.zeros((0, 2)), np.zeros((0, 64), np.float32)
    return np.concatenate(pixels), np.concatenate(descriptors)


def _distances(a: Array, b: Array) -> Array:
    """Between unit descriptors, (n, m)."""
    return np.sqrt(np.maximum(2 - 2 * (a @ b.T), 0))


def _placed(plate: Array, pixels: Array, lens: Intrinsics, levels: Array, pattern: Pattern) -> Sighting | None:
    """A plate from matches of its points (n, 2) m with pixels (n, 2), believed only if its picture fits."""
    upright = plate * [MILLI, -MILLI]  # images run down; OpenCV wants numbers of the size of pixels
    matrix, inliers = cv2.estimateAffinePartial2D(
        upright, pixels, method=cv2.RANSAC, ransacReprojThreshold=TOLERANCE, maxIters=300
    )
    if matrix is None or inliers.sum() < AGREEING:
        return None
    to_pixels = matrix[:, :2] @ np.diag([MILLI, -MILLI])  # per m right and up
    center = lens.rays(matrix[:, 2])
    step = 1e-2
    ahead = np.column_stack([lens.rays(matrix[:, 2] + step * column) for column in to_pixels.T])
    slope = (ahead - center[:, None]) / step
    if not np.isfinite(slope).all():
        return None
    sighting = align(levels, lens, pattern, Sighting(center, slope, facing(center)))
    return sighting if sighting is not None and sighting.likeness >= RECOGNISED else None
