"""A boom dressed for its picture: plates, cameras, asphalt, houses, sun. The model that is simulated stays as it is."""

from collections.abc import Sequence

import mujoco
import numpy as np

from boom_mj.cameras.intrinsics import Intrinsics
from boom_mj.cameras.targets import Plate, marker_plates, plate_picture, reference_plates
from boom_mj.cameras.view import View
from boom_mj.machine import Machine
from boom_mj.mjcf import BoomModel

Array = np.ndarray
THICKNESS = 0.01  # m, of a plate
SENSOR_PIXEL = 1e-6  # m; only ratios of it matter
CORNERS = np.array([(x, y, z) for z in (0.0, -1.0) for x, y in ((-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5))])
FACES = [(0, 1, 2), (0, 2, 3), (4, 6, 5), (4, 7, 6)]
FACES += [f for a, b in ((0, 1), (1, 2), (2, 3), (3, 0)) for f in ((a, a + 4, b + 4), (a, b + 4, b))]
ASPHALT, ASPHALT_TILE = "asphalt", 24.0  # m covered by one picture
SUN = "sun"


def dressed(boom: BoomModel, views: dict[str, View]) -> tuple[mujoco.MjModel, tuple[Plate, ...]]:
    """Model for rendering with the same coordinates as the boom's, and the plates it carries.

    Args:
        views: by camera name, of the pinhole cameras to render with.
    """
    spec = boom.spec.copy()
    plates = (*marker_plates(boom.machine, marker_places(boom)), *reference_plates(boom.machine))
    for plate in plates:
        add_plate(spec, plate)
    _add_surroundings(spec, boom.machine)
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


def add_picture(spec: mujoco.MjSpec, name: str, picture: Array) -> None:
    """A texture from (rows, columns, 3) uint8."""
    texture = spec.add_texture(name=name, type=mujoco.mjtTexture.mjTEXTURE_2D, nchannel=3)
    texture.height, texture.width = picture.shape[:2]
    texture.data = picture.tobytes()


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


def asphalt(rng: np.random.Generator, tint: Sequence[float] = (0.45, 0.46, 0.45), size: int = 1024) -> Array:
    """Ground with stains of many sizes that tiles without seams, (size, size, 3) uint8."""
    row, column = np.fft.fftfreq(size)[:, None], np.fft.rfftfreq(size)[None]
    cycles = np.hypot(row, column)
    cycles[0, 0] = np.inf
    stains = np.fft.irfft2(np.fft.rfft2(rng.normal(size=(size, size))) * cycles**-0.9, s=(size, size))
    grey = 1 + 0.14 * stains / stains.std()
    return np.clip(255 * grey[..., None] * np.array(tint), 0, 255).astype(np.uint8)


def _add_surroundings(spec: mujoco.MjSpec, machine: Machine) -> None:
    """A yard of asphalt with houses around it, under a sun; far enough away not to touch the boom."""
    rng = np.random.default_rng(36)
    add_picture(spec, ASPHALT, asphalt(rng))
    ground = spec.material("ground")
    ground.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = ASPHALT
    ground.texrepeat = [1 / ASPHALT_TILE, 1 / ASPHALT_TILE]
    plane = next(geom for geom in spec.worldbody.geoms if geom.type == mujoco.mjtGeom.mjGEOM_PLANE)
    plane.size = [0, 0, 1]
    reach = sum(link.length for link in machine.links)
    for k in range(22):
        angle, away = 2 * np.pi * (k + rng.uniform(0, 0.6)) / 22, reach * rng.uniform(2.2, 3.4)
        half = rng.uniform((3, 3, 2), (9, 9, 8))
        house = spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, size=half)
        house.pos = [away * np.cos(angle), away * np.sin(angle), half[2]]
        house.quat = [np.cos(angle / 2), 0, 0, np.sin(angle / 2)]
        house.rgba = [*(rng.uniform(0.35, 0.8) * rng.uniform(0.85, 1.0, 3)), 1]
        house.contype, house.conaffinity, house.group = 0, 0, 1
    spec.worldbody.lights[0].name = SUN
    spec.visual.headlight.ambient, spec.visual.headlight.diffuse = [0.45, 0.45, 0.47], [0.15, 0.15, 0.15]
    spec.visual.headlight.specular = [0, 0, 0]
    spec.visual.map.shadowclip = 1.2


def _quaternion(rotation: Array) -> Array:
    quaternion = np.zeros(4)
    mujoco.mju_mat2Quat(quaternion, np.ascontiguousarray(rotation, float).ravel())
    return quaternion
