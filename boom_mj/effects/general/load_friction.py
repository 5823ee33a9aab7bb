"""Friction of a joint in proportion to the load that its gears carry."""

from collections.abc import Mapping

import numpy as np

from boom_mj.effects.effect import Array, Parameter
from boom_mj.effects.general_effect import ResistEffect, Typical


class LoadFriction(ResistEffect):
    """Friction of a joint in proportion to the load that its gears carry: a share of the actuator's force."""

    id = "load_friction"
    needs = frozenset({"measured", "actuated"})
    confused_with = ("coulomb_friction", "actuator_gain")
    told_by = "the same motion with and without a load"

    @classmethod
    def sized(cls, typical: Typical) -> Mapping[str, Parameter]:
        return {"share": Parameter("", 0.0, 0.0, 0.9, 0.1)}

    def resist(self, speed: Array, load: Array) -> Array:
        small = 0.02 * max(float(np.sqrt(np.mean(speed**2))), 1e-12)
        return self.values["share"] * np.abs(load) * np.tanh(speed / small)
