"""Where the boom stands: a yard of concrete slabs between houses and trees, under sun and clouds."""

from collections.abc import Sequence

import mujoco
import numpy as np
from scipy.ndimage import map_coordinates

from boom_mj.mjcf import BoomModel

Array = np.ndarray
SUN, GROUND = "sun", "slabs"
SUN_AWAY = 45.0  # m; its rays are parallel, but shadows are thrown from a place
GROUND_TILE, SLABS = 24.0, 4  # m covered by one picture, and slabs along it
SKY_PIXELS, CLOUD_TILE = 512, 4.0  # of a face of the sky's cube; heights of the clouds covered by one picture
DAY, HORIZON, CLOUD = (0.36, 0.58, 0.86), (0.86, 0.91, 0.96), (0.97, 0.97, 0.98)
FACES = (  # of OpenGL's cube maps, y up: axis, right and down in each face's picture
    ((1, 0, 0), (0, 0, -1), (0, -1, 0)), ((-1, 0, 0), (0, 0, 1), (0, -1, 0)),
    ((0, 1, 0), (1, 0, 0), (0, 0, 1)), ((0, -1, 0), (1, 0, 0), (0, 0, -1)),
    ((0, 0, 1), (1, 0, 0), (0, -1, 0)), ((0, 0, -1), (-1, 0, 0), (0, -1, 0)),
)  # fmt: skip
HOUSES, TREES = 20, 46
GROUND_REACH = 3.6  # reaches from the middle to an edge of the ground, behind the houses
WALLS = ((0.78, 0.72, 0.63), (0.70, 0.58, 0.50), (0.74, 0.75, 0.76), (0.62, 0.66, 0.70))


def add_yard(spec: mujoco.MjSpec, reach: float) -> None:
    """Put a yard around a boom that reaches so far, m; the model's own ground and sky get pictures."""
    rng = np.random.default_rng(36)
    add_picture(spec, GROUND, slabs(rng))
    ground = spec.material("ground")
    ground.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = GROUND
    ground.texrepeat = [1 / GROUND_TILE, 1 / GROUND_TILE]
    plane = next(geom for geom in spec.worldbody.geoms if geom.type == mujoco.mjtGeom.mjGEOM_PLANE)
    plane.size = [GROUND_REACH * reach, GROUND_REACH * reach, 1]
    spec.delete(spec.texture("sky"))
    add_cube(spec, "sky", sky(rng), mujoco.mjtTexture.mjTEXTURE_SKYBOX)
    for k, wall in enumerate(WALLS):
        add_cube(spec, f"house{k}", facade(wall, 4 + k), mujoco.mjtTexture.mjTEXTURE_CUBE)
        material = spec.add_material(name=f"house{k}", specular=0.0)
        material.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = f"house{k}"
    for k in range(HOUSES):
        angle, away = 2 * np.pi * (k + rng.uniform(0, 0.6)) / HOUSES, reach * rng.uniform(2.2, 3.2)
        half = rng.uniform((4, 5, 3), (8, 12, 7))
        house = _scenery(spec, mujoco.mjtGeom.mjGEOM_BOX, half, (*_around(angle, away), half[2]))
        house.material, house.quat = f"house{k % len(WALLS)}", [np.cos(angle / 2), 0, 0, np.sin(angle / 2)]
    for _ in range(TREES):
        place, tall = _around(rng.uniform(0, 2 * np.pi), reach * rng.uniform(1.7, 2.6)), rng.uniform(4, 9)
        trunk = _scenery(spec, mujoco.mjtGeom.mjGEOM_CYLINDER, (0.03 * tall, 0.2 * tall, 0), (*place, 0.2 * tall))
        trunk.rgba = [0.3, 0.24, 0.19, 1]
        for high, wide in ((0.5, 0.27), (0.75, 0.2)):
            shape = tall * wide * rng.uniform(0.8, 1.2, 3)
            crown = _scenery(spec, mujoco.mjtGeom.mjGEOM_ELLIPSOID, shape, (*place, high * tall))
            crown.rgba = [*(np.array([0.27, 0.38, 0.17]) * rng.uniform(0.8, 1.2)), 1]
    sun = spec.worldbody.lights[0]
    sun.name, sun.diffuse, sun.specular = SUN, [0.68, 0.66, 0.62], [0.2, 0.2, 0.2]
    spec.visual.headlight.ambient, spec.visual.headlight.diffuse = [0.42, 0.43, 0.46], [0.1, 0.1, 0.1]
    spec.visual.headlight.specular = [0, 0, 0]
    spec.visual.rgba.haze = [*HORIZON, 1]
    sun.pos, spec.visual.map.shadowclip = spec.stat.center - SUN_AWAY * np.array(sun.dir), 2.5


def in_yard(boom: BoomModel) -> mujoco.MjModel:
    """A boom in its yard, to be looked at: same coordinates, nothing that labels or tracking need."""
    spec = boom.spec.copy()
    add_yard(spec, sum(link.length for link in boom.machine.links))
    return spec.compile()


def add_picture(spec: mujoco.MjSpec, name: str, picture: Array) -> None:
    """A texture from (rows, columns, 3) uint8."""
    texture = spec.add_texture(name=name, type=mujoco.mjtTexture.mjTEXTURE_2D, nchannel=3)
    texture.height, texture.width = picture.shape[:2]
    texture.data = picture.tobytes()


def add_cube(spec: mujoco.MjSpec, name: str, faces: Array, kind: mujoco.mjtTexture) -> None:
    """A texture of six square faces, (6, n, n, 3) uint8."""
    texture = spec.add_texture(name=name, type=kind, nchannel=3)
    texture.height, texture.width = 6 * faces.shape[1], faces.shape[2]
    texture.data = faces.tobytes()


def slabs(rng: np.random.Generator, tint: Sequence[float] = (0.55, 0.54, 0.51), size: int = 1024) -> Array:
    """Concrete slabs with stains of many sizes and joints between them; tiles without seams, (size, size, 3) uint8."""
    grey = 1 + 0.1 * _stains(rng, size, 0.9)
    shade = 1 + 0.04 * rng.normal(size=(SLABS, SLABS))
    grey *= np.kron(shade, np.ones((size // SLABS, size // SLABS)))
    joint = np.arange(size) % (size // SLABS) < size // 340
    grey[joint, :], grey[:, joint] = 0.7 * grey[joint, :], 0.7 * grey[:, joint]
    return np.clip(255 * grey[..., None] * np.array(tint), 0, 255).astype(np.uint8)


def sky(rng: np.random.Generator) -> Array:
    """A day's sky with a flat layer of clouds, as the faces of a cube, (6, n, n, 3) uint8."""
    edge = (np.arange(SKY_PIXELS) + 0.5) / SKY_PIXELS * 2 - 1
    right, down = (grid[..., None] for grid in np.meshgrid(edge, edge))
    rays = np.stack([np.array(a) + right * r + down * d for a, r, d in np.array(FACES)])  # (6, n, n, 3)
    high = np.maximum(rays[..., 1] / np.linalg.norm(rays, axis=-1), 1e-3)[..., None]
    field = _stains(rng, 1024, 1.7)
    share = np.moveaxis(rays[..., [0, 2]] / np.maximum(rays[..., 1:2], 1e-2), -1, 0) / CLOUD_TILE
    cover = map_coordinates(field, share * 1024, order=1, mode="grid-wrap")[..., None]
    cover = np.clip(0.45 * (cover - 0.1), 0, 0.8) * np.clip((high - 0.04) / 0.25, 0, 1)
    clear = np.array(HORIZON) + (np.array(DAY) - HORIZON) * high**0.6
    return (255 * (clear + (np.array(CLOUD) - clear) * cover)).round().astype(np.uint8)


def facade(wall: Sequence[float], storeys: int, size: int = 256) -> Array:
    """A box of a house, windows on its sides and a flat roof, (6, n, n, 3) uint8; faint beside plates."""
    side, pane = np.ones((size, size)), size // (2 * storeys)
    for row in range(storeys):
        for column in range(storeys + 1):
            top, left = round((row + 0.3) * size / storeys), round((column + 0.28) * size / (storeys + 1))
            side[top : top + pane, left : left + pane * 3 // 4] = 0.8
    roof = np.full((size, size), 0.85)
    grey = np.stack([side, side, side, side, roof, roof])
    return (255 * grey[..., None] * np.array(wall)).round().astype(np.uint8)


def _stains(rng: np.random.Generator, size: int, steepness: float) -> Array:
    """Noise of unit deviation whose amplitudes fall with a power of the frequency; tiles, (size, size)."""
    row, column = np.fft.fftfreq(size)[:, None], np.fft.rfftfreq(size)[None]
    cycles = np.hypot(row, column)
    cycles[0, 0] = np.inf
    field = np.fft.irfft2(np.fft.rfft2(rng.normal(size=(size, size))) * cycles**-steepness, s=(size, size))
    return np.asarray(field / field.std())


def _around(angle: float, away: float) -> tuple[float, float]:
    return away * np.cos(angle), away * np.sin(angle)


def _scenery(
    spec: mujoco.MjSpec, kind: mujoco.mjtGeom, size: Sequence[float] | Array, place: Sequence[float]
) -> mujoco.MjsGeom:
    geom = spec.worldbody.add_geom(type=kind, size=size, pos=place)
    geom.contype, geom.conaffinity, geom.group = 0, 0, 1
    return geom
