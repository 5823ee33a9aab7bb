"""A camera in its place: world points to pixels (32)."""

from dataclasses import dataclass

import mujoco
import numpy as np

from boom_mj.cameras.intrinsics import Intrinsics

Array = np.ndarray


@dataclass(frozen=True, eq=False)
class View:
    """P_k of eq. (32): p_camera = rotation @ (p_world - position).

    Attributes:
        rotation: R_camera_world, (3, 3); its rows are the camera's right, down and forward in the world.
        position: of the camera in the world, (3,), m.
    """

    intrinsics: Intrinsics
    rotation: Array
    position: Array

    def in_camera(self, points: Array) -> Array:
        """World points in the camera frame, (..., 3) m -> (..., 3) m."""
        return (np.asarray(points, float) - self.position) @ self.rotation.T

    def project(self, points: Array) -> Array:
        """Pixels of world points, (..., 3) m -> (..., 2); NaN behind the camera (32)."""
        return self.intrinsics.pixels(self.in_camera(points))

    @property
    def pose(self) -> tuple[Array, Array]:
        """Place of the camera frame - right, down, forward - in the world, (3,) m, and quaternion, (4,), w x y z."""
        quaternion = np.empty(4)
        mujoco.mju_mat2Quat(quaternion, self.rotation.T.ravel())
        return self.position, quaternion

    @property
    def translation(self) -> Array:
        """t of p_camera = R p_world + t, (3,), m."""
        return -self.rotation @ self.position


def look_at(position: Array, target: Array) -> Array:
    """R_camera_world of a camera with a level horizon, (3, 3)."""
    forward = np.asarray(target, float) - np.asarray(position, float)
    forward /= np.linalg.norm(forward)
    right = np.cross(forward, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    return np.array([right, np.cross(forward, right), forward])
