"""The extra friction of a joint near standstill, F exp(-(v/vs)^2) sign v, that a fast enough motion washes away."""

from collections.abc import Mapping, Sequence

import numpy as np

from boom_mj.effects import Array, Parameter, ResistEffect, Site, Values

SHARP = 0.02  # of the Stribeck speed, within which the sign changes


class StribeckFriction(ResistEffect):
    """The extra friction of a joint near standstill, F exp(-(v/vs)^2) sign v, that a fast enough motion washes away.

    It comes on top of Coulomb friction. The speed is the measured one, also where commands drive the joint.
    """

    id = "stribeck_friction"
    confused_with = ("coulomb_friction", "dry_and_viscous_friction")
    separating_experiment = "slow motions"

    @classmethod
    def parameters(cls, site: Site) -> Mapping[str, Parameter]:
        fast, size = site.speed, 0.1 * site.value
        return {
            "excess": Parameter(site.force_unit, 0.0, 0.0, 50 * size, size),
            "speed": Parameter(f"{site.unit}/s", 0.1 * fast, 1e-3 * fast, fast, fast),
        }

    def resist(self, speed: Array, load: Array) -> Array:
        share = speed / self.values["speed"]
        return self.values["excess"] * np.exp(-(share**2)) * np.tanh(share / SHARP)

    @classmethod
    def screening(cls, site: Site, lines_hz: Sequence[float] = ()) -> list[list[dict[str, float]]]:
        excess, speed = cls.parameters(site).values()
        return [[{"excess": excess.typical, "speed": share * speed.typical}] for share in (0.03, 0.1, 0.3)]

    @classmethod
    def combine(cls, site: Site, points: Sequence[Values], weights: Array) -> dict[str, float]:
        excess = cls.parameters(site)["excess"]
        return {"excess": excess.value(float(weights[0])), "speed": points[0]["speed"]}
