"""A distorting lens made of a pinhole picture: which pinhole view to render, and how to remap it."""

from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np

from boom_mj.cameras.intrinsics import Intrinsics

Array = np.ndarray
MARGIN = 3  # px around what the lens needs, for the interpolation
LARGEST = 3.0  # times the image's own size, of the pinhole picture


@dataclass(frozen=True)
class Lens:
    """Turns pictures of `source`, a pinhole camera that sees at least as much, into pictures of `intrinsics`."""

    intrinsics: Intrinsics

    @cached_property
    def source(self) -> Intrinsics:
        """The pinhole camera to render with: same pixels, as large as the lens needs."""
        own = self.intrinsics
        if own == own.pinhole:
            return own
        low, high = np.nanmin(self._wanted, axis=(0, 1)) - MARGIN, np.nanmax(self._wanted, axis=(0, 1)) + MARGIN
        limit = LARGEST * np.array([own.width, own.height])
        low, high = np.floor(np.maximum(low, -limit)), np.ceil(np.minimum(high, 2 * limit))
        width, height = (high - low + 1).astype(int)
        return Intrinsics(
            int(width), int(height), own.focal, (own.center[0] - float(low[0]), own.center[1] - float(low[1]))
        )

    @cached_property
    def _wanted(self) -> Array:
        """Pinhole pixel that every pixel of the image shows, relative to an unpadded pinhole image, (h, w, 2)."""
        own = self.intrinsics
        grid = np.stack(np.meshgrid(np.arange(own.width), np.arange(own.height)), axis=-1)
        return own.rays(grid) * own.focal + own.center

    @cached_property
    def _tables(self) -> tuple[Array, Array]:
        shift = np.array(self.source.center) - self.intrinsics.center
        where = np.nan_to_num(self._wanted + shift, nan=-1e4).astype(np.float32)
        return where[..., 0], where[..., 1]

    @cached_property
    def _back(self) -> tuple[Array, Array]:
        """Pixel of the image that every pixel of its pinhole camera shows; outside where the lens saw nothing."""
        own = self.intrinsics
        grid = np.stack(np.meshgrid(np.arange(own.width), np.arange(own.height)), axis=-1)
        rays = np.concatenate([own.pinhole.rays(grid), np.ones((*grid.shape[:2], 1))], axis=-1)
        where = np.nan_to_num(own.pixels(rays), nan=-1e4).astype(np.float32)
        return where[..., 0], where[..., 1]

    def straightened(self, picture: Array, exact: bool = False) -> Array:
        """A picture of the lens as its pinhole camera would have taken it; black where the lens saw nothing.

        Args:
            exact: for values that must not be mixed.
        """
        if self.intrinsics == self.intrinsics.pinhole:
            return picture
        how = cv2.INTER_NEAREST if exact else cv2.INTER_CUBIC
        return cv2.remap(picture, *self._back, how, borderMode=cv2.BORDER_CONSTANT)

    def picture(self, pinhole: Array) -> Array:
        """Colours as the lens shows them, (source h, source w, 3) -> (h, w, 3)."""
        return self._remap(pinhole, cv2.INTER_CUBIC)

    def exact(self, pinhole: Array) -> Array:
        """The same for values that must not be mixed: depth, identities."""
        return self._remap(pinhole, cv2.INTER_NEAREST)

    def _remap(self, pinhole: Array, how: int) -> Array:
        if self.source is self.intrinsics:
            return pinhole
        return cv2.remap(pinhole, *self._tables, how, borderMode=cv2.BORDER_CONSTANT)
