"""The cameras of a machine file as views."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from boom_mj.cameras.intrinsics import Intrinsics
from boom_mj.cameras.view import View, look_at
from boom_mj.errors import InputError
from boom_mj.machine import Camera, Machine


@dataclass(frozen=True, eq=False)
class RigCamera:
    """A camera of the rig: what the file says of it, and its view."""

    file: Camera
    view: View

    @property
    def name(self) -> str:
        return self.file.name


def rig_of(
    machine: Machine, names: Sequence[str] = (), scale: float = 1.0, distortion: bool = True
) -> tuple[RigCamera, ...]:
    """Cameras of a machine by name, all of them if none is named.

    Args:
        scale: of the image sizes.
        distortion: False gives every camera an ideal lens.

    Raises:
        InputError: a machine without cameras, or an unknown name.
    """
    known = {camera.name: camera for camera in machine.camera}
    if not known:
        raise InputError(f"the machine {machine.name!r} has no cameras: its file needs [[camera]] sections")
    if unknown := [name for name in names if name not in known]:
        raise InputError(f"there is no camera {unknown[0]!r}; {machine.name} has {', '.join(known)}")
    return tuple(_placed(known[name], scale, distortion) for name in names or known)


def _placed(camera: Camera, scale: float, distortion: bool) -> RigCamera:
    width, height = camera.resolution
    center = camera.principal_point or ((width - 1) / 2, (height - 1) / 2)
    intrinsics = Intrinsics(width, height, camera.focal_length, center, camera.distortion).scaled(scale)
    rotation, position = look_at(np.array(camera.position), np.array(camera.look_at)), np.array(camera.position)
    return RigCamera(camera, View(intrinsics if distortion else intrinsics.pinhole, rotation, position))
