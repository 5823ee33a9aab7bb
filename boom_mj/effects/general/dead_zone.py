"""Commands below some size do nothing, and larger ones act less that size."""

from collections.abc import Mapping

import numpy as np

from boom_mj.effects.effect import Array, Parameter
from boom_mj.effects.general_effect import CommandEffect, Typical

SOFT = 0.05  # of the rms of what acts, over which the jump of the inverse is smoothed


class DeadZone(CommandEffect):
    """Commands below some size do nothing, and larger ones act less that size."""

    id = "dead_zone"
    sizes = (0.3, 1.0, 3.0)
    confused_with = ("coulomb_friction", "backlash")
    told_by = "small commands"

    @classmethod
    def sized(cls, typical: Typical) -> Mapping[str, Parameter]:
        return {"width": Parameter(typical.unit, 0.0, 0.0, 3 * typical.value, 0.1 * typical.value)}

    def act(self, time: Array, command: Array) -> Array:
        return np.sign(command) * np.maximum(np.abs(command) - self.values["width"], 0.0)

    def command(self, time: Array, action: Array) -> Array:
        return action + self.values["width"] * np.tanh(action / SOFT / max(float(np.sqrt(np.mean(action**2))), 1e-12))
