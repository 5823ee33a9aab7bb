"""From a direction in front of a camera to a pixel, and back: pinhole and Brown's distortion.

Camera frame as in OpenCV: x right, y down, z forward. Pixels: the centre of the upper left one is (0, 0).
With (x, y) = (X/Z, Y/Z) and r^2 = x^2 + y^2,

    x_d = x (1 + k1 r^2 + k2 r^4 + k3 r^6) + 2 p1 x y + p2 (r^2 + 2 x^2)
    y_d = y (1 + k1 r^2 + k2 r^4 + k3 r^6) + p1 (r^2 + 2 y^2) + 2 p2 x y
    u = fx x_d + cx,  v = fy y_d + cy

(the intrinsic part of P_k in eq. 32).
"""

from dataclasses import dataclass, replace

import numpy as np

Array = np.ndarray
NEAR = 1e-6  # m, depth from which on a point lies in front of the camera


@dataclass(frozen=True)
class Intrinsics:
    """What a lens and its sensor do.

    Attributes:
        width, height: of the image, px.
        focal: fx, fy, px.
        center: principal point cx, cy, px.
        distortion: k1, k2, p1, p2, k3.
    """

    width: int
    height: int
    focal: tuple[float, float]
    center: tuple[float, float]
    distortion: tuple[float, float, float, float, float] = (0.0, 0.0, 0.0, 0.0, 0.0)

    @property
    def matrix(self) -> Array:
        """K, (3, 3), px."""
        return np.array([[self.focal[0], 0, self.center[0]], [0, self.focal[1], self.center[1]], [0, 0, 1.0]])

    @property
    def pinhole(self) -> "Intrinsics":
        """The same without distortion."""
        return replace(self, distortion=(0.0, 0.0, 0.0, 0.0, 0.0))

    def scaled(self, factor: float) -> "Intrinsics":
        """The same lens before a sensor with coarser or finer pixels."""
        size = max(1, round(self.width * factor)), max(1, round(self.height * factor))
        focal = self.focal[0] * factor, self.focal[1] * factor
        center = (self.center[0] + 0.5) * factor - 0.5, (self.center[1] + 0.5) * factor - 0.5
        return Intrinsics(*size, focal, center, self.distortion)

    def distort(self, points: Array) -> Array:
        """Where the lens puts ideal points; (..., 2) -> (..., 2), both at unit depth."""
        k1, k2, p1, p2, k3 = self.distortion
        x, y = np.moveaxis(np.asarray(points, float), -1, 0)
        square = x * x + y * y
        radial = 1 + square * (k1 + square * (k2 + square * k3))
        return np.stack(
            [
                x * radial + 2 * p1 * x * y + p2 * (square + 2 * x * x),
                y * radial + p1 * (square + 2 * y * y) + 2 * p2 * x * y,
            ],
            axis=-1,
        )

    def undistort(self, points: Array) -> Array:
        """The inverse of `distort` by fixed point iteration, (..., 2); NaN where a lens has no such point."""
        target = np.asarray(points, float)
        ideal = target.copy()
        with np.errstate(over="ignore", invalid="ignore"):
            for _ in range(50):
                step = target - self.distort(ideal)
                ideal = ideal + step
                if np.nanmax(np.abs(step), initial=0.0) < 1e-12:
                    break
            wrong = ~(np.abs(self.distort(ideal) - target).max(axis=-1) < 1e-9)
        return np.where(wrong[..., None], np.nan, ideal)

    def pixels(self, points: Array) -> Array:
        """Pixels of points in the camera frame, (..., 3) m -> (..., 2); NaN behind the camera or beyond the lens.

        Far outside the image Brown's polynomial folds back; what it folds counts as not seen.
        """
        points = np.asarray(points, float)
        depth = points[..., 2:]
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            ideal = np.where(depth > NEAR, points[..., :2] / depth, np.nan)
            seen = np.hypot(*np.moveaxis(ideal, -1, 0)) <= self.reach
            return np.where(seen[..., None], self.distort(ideal) * self.focal + self.center, np.nan)

    def rays(self, pixels: Array) -> Array:
        """Ideal points at unit depth of pixels, (..., 2) -> (..., 2)."""
        return self.undistort((np.asarray(pixels, float) - self.center) / self.focal)

    @property
    def reach(self) -> float:
        """Largest r = tan(angle off the axis) up to which the distorted radius grows with r; inf without distortion."""
        k1, k2, _, _, k3 = self.distortion
        slope = [7 * k3, 0, 5 * k2, 0, 3 * k1, 0, 1]  # d/dr of r (1 + k1 r^2 + k2 r^4 + k3 r^6)
        turning = [root.real for root in np.roots(slope) if abs(root.imag) < 1e-9 and root.real > 0]
        return min(turning, default=np.inf)

    def contains(self, pixels: Array) -> Array:
        """Whether pixels lie in the image, (..., 2) -> (...) bool; NaN does not."""
        u, v = np.moveaxis(np.asarray(pixels), -1, 0)
        with np.errstate(invalid="ignore"):
            return (u >= -0.5) & (v >= -0.5) & (u < self.width - 0.5) & (v < self.height - 0.5)
