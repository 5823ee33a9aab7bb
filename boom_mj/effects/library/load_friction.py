"""Friction of a joint in proportion to the load that its gears carry."""

from collections.abc import Mapping

import numpy as np

from boom_mj.effects import Array, Parameter, ResistEffect, Site


class LoadFriction(ResistEffect):
    """Friction of a joint in proportion to the load that its gears carry: a share of the actuator's force."""

    id = "load_friction"
    needs = frozenset({"mjcf", "measured", "actuated"})
    confused_with = ("coulomb_friction", "actuator_gain")
    separating_experiment = "the same motion with and without a load"

    @classmethod
    def parameters(cls, site: Site) -> Mapping[str, Parameter]:
        return {"share": Parameter("1", 0.0, 0.0, 0.9, 0.1, likely=(0.0, 0.4))}  # worm gears lose 40 %

    def resist(self, speed: Array, load: Array) -> Array:
        small = 0.02 * max(float(np.sqrt(np.mean(speed**2))), 1e-12)
        return self.values["share"] * np.abs(load) * np.tanh(speed / small)
