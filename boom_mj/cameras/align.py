"""Where exactly a plate is in a picture: Gauss-Newton on grey levels, to a few hundredths of a pixel.

A point (a, b) of the plate (m from its centre, right and up) is seen at the ideal point

    m + (J_a a + J_b b) / (1 + h_a a + h_b b),   h = -(n_x, n_y) J / (n . (m_x, m_y, 1)),

n the plate's normal in the camera frame: six unknowns m and J, the perspective follows from n. The lens then makes
pixels of ideal points. Minimised is the difference of the normalised grey levels of picture and plate.
"""

from dataclasses import dataclass
from functools import lru_cache

import cv2
import numpy as np

from boom_mj.cameras.intrinsics import Intrinsics

Array = np.ndarray
ROUNDS = 25
SETTLED, RESTLESS = 0.01, 0.1  # px, a last step of the centre that ends the rounds, and that is too long after all
LONGEST_STEP = 3.0  # px
LEAST_CELLS = 6  # of a template, across
FINEST_CELLS = 96  # along: a closer plate says nothing new


@dataclass(frozen=True, eq=False)
class Pattern:
    """What a plate looks like: its picture, (rows, columns) uint8, and its size along columns and rows, m."""

    name: str
    picture: Array
    size: tuple[float, float]


@dataclass(frozen=True, eq=False)
class Sighting:
    """A plate in a picture.

    Attributes:
        center: ideal point m of its centre, (2,).
        slope: J, (2, 2), 1/m.
        normal: n in the camera frame, (3,).
        likeness: correlation of picture and plate, 1 at best.
        deviation: standard deviation of the centre that the grey levels leave, px.
    """

    center: Array
    slope: Array
    normal: Array
    likeness: float = 0.0
    deviation: float = np.inf

    def points(self, plate: Array) -> Array:
        """Ideal points of plate points, (n, 2) m -> (n, 2)."""
        across = self.normal[:2] @ self.slope / -(self.normal @ [*self.center, 1.0])
        return self.center + plate @ self.slope.T / (1 + plate @ across)[:, None]

    def pixel(self, lens: Intrinsics) -> Array:
        """Where its centre is, (2,), px."""
        return np.asarray(lens.distort(self.center) * lens.focal + lens.center)

    def corners(self, lens: Intrinsics, size: tuple[float, float]) -> Array:
        """Upper left, upper right, lower right, lower left, (4, 2), px."""
        plate = np.array([(-0.5, 0.5), (0.5, 0.5), (0.5, -0.5), (-0.5, -0.5)]) * size
        return np.asarray(lens.distort(self.points(plate)) * lens.focal + lens.center)


def facing(center: Array) -> Array:
    """Normal of a plate that faces the camera, (3,)."""
    return -np.array([*center, 1.0]) / np.linalg.norm([*center, 1.0])


def align(picture: Array, lens: Intrinsics, pattern: Pattern, guess: Sighting) -> Sighting | None:
    """Refine a sighting.

    Args:
        picture: grey levels, (h, w) float32.
        guess: within about half a blob of the truth, some 2 px for a plate of 40 px.

    Returns:
        The sighting with its likeness, whatever that is; None if the plate left the picture or the search its reason.
    """
    center, slope = guess.center.copy(), guess.slope.copy()
    focal = np.array(lens.focal)
    width = float(np.linalg.norm(slope[:, 0] * focal)) * pattern.size[0]
    height = float(np.linalg.norm(slope[:, 1] * focal)) * pattern.size[1]
    if not (np.isfinite(width + height) and min(width, height) > LEAST_CELLS / 2):
        return None
    cells, wanted = _template(pattern.name, pattern.size, _Key(pattern.picture), _columns(width))
    scale = np.array(pattern.size).max() / 2
    likeness, spread, moved = 0.0, np.inf, np.inf
    for _ in range(ROUNDS):
        sight = Sighting(center, slope, guess.normal)
        pixels = lens.distort(sight.points(cells)) * focal + lens.center  # (n, 2)
        if not lens.contains(pixels).all():
            return None
        grey = _sampled(picture, pixels)
        contrast = grey.std()
        if contrast < 1.0:
            return None
        seen = (grey - grey.mean()) / contrast
        likeness = float(seen @ wanted) / len(wanted)
        gradient = np.column_stack([_slope_of(picture, pixels, k) for k in (0, 1)]) / contrast
        local = _lens_slope(lens, center) * focal[:, None]
        by_point = gradient @ local  # d grey / d ideal point, (n, 2)
        by = np.column_stack([by_point, by_point * cells[:, :1] / scale, by_point * cells[:, 1:] / scale])
        by -= by.mean(axis=0)
        by -= np.outer(seen, seen @ by) / len(seen)  # brightness and contrast are free
        normal_matrix = by.T @ by
        try:
            step = np.linalg.solve(normal_matrix, by.T @ (wanted * likeness - seen))
        except np.linalg.LinAlgError:
            return None
        moved = float(np.linalg.norm(local @ step[:2]))
        if not np.isfinite(moved):
            return None
        step *= min(1.0, LONGEST_STEP / max(moved, 1e-12))
        center = center + step[:2]
        slope = slope + np.column_stack([step[2:4], step[4:6]]) / scale
        if moved < SETTLED:
            break
    if moved < RESTLESS:
        rest = (1 - likeness**2) * len(wanted) / max(len(wanted) - 8, 1)
        variance = np.linalg.inv(normal_matrix)[:2, :2] * rest
        spread = float(np.sqrt(np.trace(local @ variance @ local.T) / 2))
    return Sighting(center, slope, guess.normal, likeness, spread)


def _columns(width: float) -> int:
    """Cells of a template for a plate of some px, in steps of a third so that few templates are made."""
    return int(np.clip(np.round(8 * 1.35 ** np.round(np.log(max(width, 8) / 8) / np.log(1.35))), 8, FINEST_CELLS))


class _Key:
    """A picture as a key of a cache: by identity."""

    def __init__(self, picture: Array) -> None:
        self.picture = picture

    def __hash__(self) -> int:
        return id(self.picture)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Key) and other.picture is self.picture


@lru_cache(maxsize=1024)
def _template(name: str, size: tuple[float, float], key: _Key, columns: int) -> tuple[Array, Array]:
    """Cell centres, (n, 2) m, and their normalised grey levels, (n,); without the outermost cells."""
    rows = max(LEAST_CELLS, round(columns * size[1] / size[0]))
    grey = cv2.resize(key.picture.astype(np.float32), (columns, rows), interpolation=cv2.INTER_AREA)[1:-1, 1:-1]
    a = ((np.arange(columns) + 0.5) / columns - 0.5)[1:-1] * size[0]
    b = (0.5 - (np.arange(rows) + 0.5) / rows)[1:-1] * size[1]
    cells = np.stack(np.meshgrid(a, b), axis=-1).reshape(-1, 2)
    flat = grey.ravel().astype(float)
    return cells, (flat - flat.mean()) / flat.std()


def _sampled(picture: Array, pixels: Array) -> Array:
    """Grey levels between pixels, (n,)."""
    where = pixels.astype(np.float32)
    return cv2.remap(picture, where[:, :1], where[:, 1:], cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE)[
        :, 0
    ].astype(float)


def _slope_of(picture: Array, pixels: Array, axis: int) -> Array:
    """Derivative of the grey levels along u (axis 0) or v (axis 1), (n,), per px."""
    step = np.array([0.5, 0.0]) if axis == 0 else np.array([0.0, 0.5])
    return _sampled(picture, pixels + step) - _sampled(picture, pixels - step)


def _lens_slope(lens: Intrinsics, center: Array) -> Array:
    """Derivative of the lens at an ideal point, (2, 2)."""
    step = 1e-4
    return np.column_stack(
        [(lens.distort(center + step * e) - lens.distort(center - step * e)) / (2 * step) for e in np.eye(2)]
    )
