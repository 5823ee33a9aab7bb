"""Commands that do nothing within limits that differ between the directions."""

from collections.abc import Mapping

import numpy as np

from boom_mj.effects import ActuatorEffect, Array, Parameter, Site
from boom_mj.effects.library.dead_zone import FORCES, SOFT


class AsymmetricDeadZone(ActuatorEffect):
    """Commands between -`backward` and `forward` do nothing, and larger ones act less that limit."""

    id = "asymmetric_dead_zone"
    sizes = (0.3, 1.0, 3.0)
    special_cases = ("dead_zone",)
    confused_with = ("dead_zone", "actuator_bias", "asymmetric_friction")
    separating_experiment = "small commands both ways"

    @classmethod
    def parameters(cls, site: Site) -> Mapping[str, Parameter]:
        likely = (
            (0.0, 0.05 * site.value) if site.unit in FORCES else None
        )  # a force that is controlled has next to none
        width = Parameter(site.unit, 0.0, 0.0, 3 * site.value, 0.1 * site.value, likely=likely)
        return {"forward": width, "backward": width}

    def apply(self, time: Array, true: Array) -> Array:
        forward, backward = self.values["forward"], self.values["backward"]
        return np.maximum(true - forward, 0.0) + np.minimum(true + backward, 0.0)

    def invert(self, time: Array, read: Array) -> Array:
        forward, backward = self.values["forward"], self.values["backward"]
        side = np.tanh(read / SOFT / max(float(np.sqrt(np.mean(read**2))), 1e-12))
        return read + (forward - backward) / 2 * np.abs(side) + (forward + backward) / 2 * side
