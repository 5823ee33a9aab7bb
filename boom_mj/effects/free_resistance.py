"""What resists a joint as any function of its speed: no effect of the library, but what any other law is like."""

from collections.abc import Mapping
from itertools import pairwise, product

import numpy as np

from boom_mj.effects.base import Array
from boom_mj.effects.kinds import ResistEffect
from boom_mj.effects.parameter import Parameter
from boom_mj.effects.site import Site

STANDSTILL = 0.02  # of the joint's rms speed, within which dry parts change their sign
BENDS = (0.5, 1.0)  # of the joint's rms speed, where slopes change
WAYS = ("forward", "backward")


class FreeResistance(ResistEffect):
    """Piecewise linear: of each direction a dry part, and slopes over three ranges of speed, of any sign."""

    id = "free_resistance"

    @classmethod
    def parameters(cls, site: Site) -> Mapping[str, Parameter]:
        dry = Parameter(site.force_unit, 0.0, -20 * site.value, 20 * site.value, 0.1 * site.value)
        size = 0.1 * site.value / site.speed
        slope = Parameter(f"{site.force_unit} s/{site.unit}", 0.0, -200 * size, 200 * size, size)
        slopes = {f"{way}_{k}": slope for way, k in product(WAYS, range(len(BENDS) + 1))}
        return {**dict.fromkeys(WAYS, dry), **slopes}

    def resist(self, speed: Array, load: Array) -> Array:
        rms = max(float(np.sqrt(np.mean(speed**2))), 1e-12)
        ends, size = rms * np.array([0.0, *BENDS, np.inf]), np.abs(speed)
        ranges = [np.clip(size - low, 0.0, high - low) for low, high in pairwise(ends)]

        def along(way: str) -> Array:
            slopes = sum((self.values[f"{way}_{k}"] * part for k, part in enumerate(ranges)), np.zeros_like(size))
            return self.values[way] * np.abs(np.tanh(speed / (STANDSTILL * rms))) + slopes

        return np.sign(speed) * np.where(speed > 0, along("forward"), along("backward"))
