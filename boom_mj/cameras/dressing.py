"""A boom dressed for its picture: plates, cameras, the yard around it. The model that is simulated stays as it is."""

from collections.abc import Sequence

import mujoco
import numpy as np

from boom_mj.cameras.intrinsics import Intrinsics
from boom_mj.cameras.targets import Plate, marker_plates, plate_picture, reference_plates
from boom_mj.cameras.view import View
from boom_mj.cameras.yard import add_picture, add_yard
from boom_mj.mjcf import BoomModel

Array = np.ndarray
THICKNESS = 0.01  # m, of a plate
SENSOR_PIXEL = 1e-6  # m; only ratios of it matter
CORNERS = np.array([(x, y, z) for z in (0.0, -1.0) for x, y in ((-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5))])
FACES = [(0, 1, 2), (0, 2, 3), (4, 6, 5), (4, 7, 6)]
FACES += [f for a, b in ((0, 1), (1, 2), (2, 3), (3, 0)) for f in ((a, a + 4, b + 4), (a, b + 4, b))]


def dressed(boom: BoomModel, views: dict[str, View]) -> tuple[mujoco.MjModel, tuple[Plate, ...]]:
    """Model for rendering with the same coordinates as the boom's, and the plates it carries.

    Args:
        views: by camera name, of the pinhole cameras to render with.
    """
    spec = boom.spec.copy()
    plates = (*marker_plates(boom.machine, marker_places(boom)), *reference_plates(boom.machine))
    for plate in plates:
        add_plate(spec, plate)
    add_yard(spec, sum(link.length for link in boom.machine.links))
    add_cameras(spec, views)
    return spec.compile(), plates


def marker_places(boom: BoomModel) -> list[tuple[str, Array]]:
    """Body and position in its frame of marker1, marker2, ..."""
    count = len(boom.machine.links) * len(boom.machine.sensors.markers_x)
    sites = [boom.spec.site(f"marker{k + 1}") for k in range(count)]
    return [(site.parent.name, np.array(site.pos)) for site in sites]


def add_plate(spec: mujoco.MjSpec, plate: Plate) -> None:
    """A thin textured board without mass or contact; its front is at the plate's centre."""
    add_board(spec, spec.body(plate.body), plate.name, plate.size, plate_picture(plate.name, plate.size))
    geom = spec.geom(plate.name)
    geom.pos, geom.quat = plate.center, _quaternion(plate.axes)


def add_board(
    spec: mujoco.MjSpec, body: mujoco.MjsBody, name: str, size: tuple[float, float], picture: Array
) -> mujoco.MjsGeom:
    """A picture (rows, columns) uint8 on a thin board that faces +z of its own frame."""
    coordinates = np.column_stack([CORNERS[:, 0] + 0.5, 0.5 - CORNERS[:, 1]])
    spec.add_mesh(
        name=name,
        uservert=(CORNERS * [*size, THICKNESS]).ravel(),
        userface=np.ravel(FACES),
        usertexcoord=coordinates.ravel(),
    )
    add_picture(spec, name, np.repeat(picture[..., None], 3, axis=2))
    material = spec.add_material(name=name, specular=0.05, shininess=0.1)
    material.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = name
    geom = body.add_geom(name=name, type=mujoco.mjtGeom.mjGEOM_MESH, meshname=name, material=name)
    geom.contype, geom.conaffinity, geom.mass, geom.group = 0, 0, 0, 1
    return geom


def add_cameras(spec: mujoco.MjSpec, views: dict[str, View]) -> None:
    """Pinhole cameras; MuJoCo's look along -z with y up, and count the principal point from the middle."""
    for name, view in views.items():
        lens = view.intrinsics
        camera = spec.worldbody.add_camera(name=name, pos=view.position)
        camera.quat = _quaternion(view.rotation.T @ np.diag([1.0, -1.0, -1.0]))
        camera.resolution = lens.width, lens.height
        camera.sensor_size = lens.width * SENSOR_PIXEL, lens.height * SENSOR_PIXEL
        camera.focal_pixel = lens.focal
        camera.principal_pixel = (lens.width - 1) / 2 - lens.center[0], (lens.height - 1) / 2 - lens.center[1]
    allow_sizes(spec, [view.intrinsics for view in views.values()])


def allow_sizes(spec: mujoco.MjSpec, sizes: Sequence[Intrinsics]) -> None:
    """Room for pictures of these sizes in the offscreen buffer."""
    spec.visual.global_.offwidth = max(lens.width for lens in sizes)
    spec.visual.global_.offheight = max(lens.height for lens in sizes)


def _quaternion(rotation: Array) -> Array:
    quaternion = np.zeros(4)
    mujoco.mju_mat2Quat(quaternion, np.ascontiguousarray(rotation, float).ravel())
    return quaternion
