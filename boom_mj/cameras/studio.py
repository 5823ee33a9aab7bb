"""Pictures of a moving boom from MuJoCo's offscreen renderer: colour, depth, identities, and what is in sight."""

import os
import sys
from copy import copy
from dataclasses import replace
from functools import cached_property
from typing import Self

import cv2
import mujoco
import numpy as np

from boom_mj.cameras.film import Film
from boom_mj.cameras.intrinsics import Intrinsics
from boom_mj.cameras.lens import Lens
from boom_mj.cameras.light import Weather
from boom_mj.cameras.view import View
from boom_mj.cameras.yard import GROUND
from boom_mj.engine import NAME
from boom_mj.errors import RenderError

Array = np.ndarray
NO_OPENGL = (
    "MuJoCo cannot render here ({reason}): without a display it needs EGL; install libegl1 and libgl1-mesa-dri "
    "(Debian, Ubuntu) or the driver's EGL library, and leave MUJOCO_GL unset or set it to egl"
)


def choose_headless() -> None:
    """Let processes started from here render without a display, unless the user chose something else."""
    if sys.platform == "linux" and not any(os.environ.get(name) for name in ("DISPLAY", "WAYLAND_DISPLAY")):
        os.environ.setdefault(NAME, "egl")


def open_renderer(model: mujoco.MjModel, size: Intrinsics) -> mujoco.Renderer:
    """A renderer for pictures of a size.

    Raises:
        RenderError: there is no OpenGL; the sentence says what to install.
    """
    try:
        return mujoco.Renderer(model, size.height, size.width)
    except (ImportError, AttributeError, RuntimeError, OSError, mujoco.FatalError) as error:
        said = f"MUJOCO_GL={os.environ[NAME]}" if NAME in os.environ else "MUJOCO_GL unset"
        reason = str(error).split("\n")[0] or type(error).__name__
        raise RenderError(NO_OPENGL.format(reason=f"{said}: {reason}")) from error


class Studio:
    """A dressed boom in front of its cameras; holds OpenGL contexts, so close it."""

    def __init__(self, film: Film) -> None:
        self.film, self.model = film, copy(film.model)  # weather changes it
        self.data = mujoco.MjData(self.model)
        self.rig = {camera.name: camera for camera in film.rig}
        self.lenses = {camera.name: Lens(camera.view.intrinsics) for camera in film.rig}
        self._renderers: dict[tuple[int, int], mujoco.Renderer] = {}
        self._plain = self.model.cam_pos.copy(), self.model.cam_quat.copy()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        for renderer in self._renderers.values():
            renderer.close()

    def pose(self, time: float) -> None:
        """Move the boom."""
        self.data.qpos[:] = self.film.at(time)
        mujoco.mj_kinematics(self.model, self.data)
        mujoco.mj_comPos(self.model, self.data)
        mujoco.mj_camlight(self.model, self.data)

    def set_weather(self, weather: Weather) -> None:
        """Light, ground and camera places from the next `pose` on."""
        upload = weather.apply(self.model)
        self.model.cam_pos[:], self.model.cam_quat[:] = self._plain
        for name in self.rig:
            view, camera = self.view(name, weather), self.model.camera(name)
            camera.pos[:] = view.position
            mujoco.mju_mat2Quat(camera.quat, (view.rotation.T @ np.diag([1.0, -1.0, -1.0])).ravel())
        for renderer in self._renderers.values() if upload else ():
            self._upload(renderer)

    def view(self, name: str, weather: Weather | None = None) -> View:
        """Where a camera is and looks."""
        view = self.rig[name].view
        if weather is None or weather.nudge is None:
            return view
        shift, turn = weather.nudge[name]
        return replace(view, position=view.position + shift, rotation=cv2.Rodrigues(turn)[0] @ view.rotation)

    def picture(self, name: str) -> Array:
        """What a camera sees, (h, w, 3) uint8, red green blue."""
        renderer = self._aimed(name)
        return self.lenses[name].picture(renderer.render())

    def depth(self, name: str) -> Array:
        """Distance along the optical axis, (h, w) float32, m."""
        renderer = self._aimed(name)
        renderer.enable_depth_rendering()
        depth = renderer.render()
        renderer.disable_depth_rendering()
        return self.lenses[name].exact(depth)

    def bodies(self, name: str) -> Array:
        """Number of the body that a pixel shows, (h, w) uint8; 0 for the world."""
        renderer = self._aimed(name)
        renderer.enable_segmentation_rendering()
        geoms = renderer.render()[..., 0]
        renderer.disable_segmentation_rendering()
        table = np.append(self.model.geom_bodyid, 0).astype(np.uint8)  # -1, the sky, is the last
        return self.lenses[name].exact(table[geoms])

    @cached_property
    def _outlines(self) -> mujoco.MjvOption:
        option = mujoco.MjvOption()
        option.sitegroup[:] = 0
        return option

    def _aimed(self, name: str) -> mujoco.Renderer:
        size = self.lenses[name].source
        key = (size.width, size.height)
        if key not in self._renderers:
            self._renderers[key] = open_renderer(self.model, size)
        self._renderers[key].update_scene(self.data, name, self._outlines)
        return self._renderers[key]

    def _upload(self, renderer: mujoco.Renderer) -> None:
        context = renderer._mjr_context
        renderer._gl_context.make_current()
        mujoco.mjr_uploadTexture(self.model, context, self.model.texture(GROUND).id)

    def visible(self, view: View, points: Array, owner: str) -> Array:
        """Whether nothing stands between a camera and points on a geom, (n, 3) -> (n,) bool."""
        rays = points - view.position
        distance = np.linalg.norm(rays, axis=1)
        hit, geoms = np.zeros(len(points)), np.full(len(points), -1, np.int32)
        mujoco.mj_multiRay(
            self.model, self.data, view.position, np.ravel(rays / distance[:, None]), None, True, -1, geoms, hit,
            None, len(points), mujoco.mjMAXVAL,
        )  # fmt: skip
        return np.asarray(geoms == self.model.geom(owner).id)
