"""Domain randomisation: sun, ground and camera places drawn anew for every frame, from the seed and the frame alone."""

from collections.abc import Set
from dataclasses import dataclass

import mujoco
import numpy as np

from boom_mj.cameras.yard import GROUND, SUN, SUN_AWAY, slabs

Array = np.ndarray
KINDS = ("light", "texture", "pose")
POSE_SPREAD = (0.5, 0.02)  # m, rad: standard deviations of a camera's place and direction


@dataclass(frozen=True, eq=False)
class Weather:
    """How the scene of one frame differs from the plain one; None leaves it plain.

    Attributes:
        sun: direction of its rays, (3,), and its colour, (3,); sky is the ambient grey.
        ground: picture of the slabs, (n, n, 3) uint8.
        nudge: displacement (3,) m and rotation vector (3,) rad of every camera, by name.
    """

    sun: Array | None = None
    colour: Array | None = None
    sky: float | None = None
    ground: Array | None = None
    nudge: dict[str, tuple[Array, Array]] | None = None

    def apply(self, model: mujoco.MjModel) -> bool:
        """Put sun and ground into a model for rendering; True if its ground must be uploaded again."""
        if self.sun is not None and self.colour is not None and self.sky is not None:
            light = model.light(SUN)
            light.dir[:], light.diffuse[:] = self.sun, self.colour
            light.pos[:] = model.stat.center - SUN_AWAY * self.sun
            model.vis.headlight.ambient[:] = self.sky
        if self.ground is None:
            return False
        texture = model.texture(GROUND)
        start = model.tex_adr[texture.id]
        model.tex_data[start : start + self.ground.size] = self.ground.ravel()
        return True


def weather_of(frame: int, kinds: Set[str], seed: int, cameras: tuple[str, ...]) -> Weather:
    """The weather of a frame: the same for all cameras, and whatever was rendered before."""
    rng = np.random.default_rng((seed, frame))
    height, azimuth, warm = np.radians(rng.uniform(15, 75)), rng.uniform(0, 2 * np.pi), rng.uniform(0, 1)
    rays = -np.array([np.cos(height) * np.cos(azimuth), np.cos(height) * np.sin(azimuth), np.sin(height)])
    colour = rng.uniform(0.25, 0.9) * np.array([1.0, 1 - 0.12 * warm, 1 - 0.3 * warm])
    sky, tint = rng.uniform(0.25, 0.55), (rng.uniform(0.25, 0.7) * rng.uniform(0.8, 1.0, 3)).tolist()
    place, turn = POSE_SPREAD
    nudge = {name: (place * rng.normal(size=3), turn * rng.normal(size=3)) for name in cameras}
    lit, laid, moved = (kind in kinds for kind in KINDS)
    return Weather(
        sun=rays if lit else None,
        colour=colour if lit else None,
        sky=sky if lit else None,
        ground=slabs(rng, tint) if laid else None,
        nudge=nudge if moved else None,
    )
