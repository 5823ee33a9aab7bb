"""Commands below some size do nothing, and larger ones act less that size."""

from collections.abc import Mapping

import numpy as np

from boom_mj.effects import ActuatorEffect, Array, Parameter, Site

FORCES = ("N", "N m")  # units of commands that some inner loop makes come true
SOFT = 0.05  # of the rms of what acts, over which the jump of the inverse is smoothed


class DeadZone(ActuatorEffect):
    """Commands below some size do nothing, and larger ones act less that size."""

    id = "dead_zone"
    sizes = (0.3, 1.0, 3.0)
    confused_with = ("coulomb_friction", "backlash", "dry_and_viscous_friction", "asymmetric_dead_zone")
    separating_experiment = "small commands"

    @classmethod
    def parameters(cls, site: Site) -> Mapping[str, Parameter]:
        likely = (
            (0.0, 0.05 * site.value) if site.unit in FORCES else None
        )  # a force that is controlled has next to none
        return {"width": Parameter(site.unit, 0.0, 0.0, 3 * site.value, 0.1 * site.value, likely=likely)}

    def apply(self, time: Array, true: Array) -> Array:
        return np.sign(true) * np.maximum(np.abs(true) - self.values["width"], 0.0)

    def invert(self, time: Array, read: Array) -> Array:
        return read + self.values["width"] * np.tanh(read / SOFT / max(float(np.sqrt(np.mean(read**2))), 1e-12))
