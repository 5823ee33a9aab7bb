"""The extra friction of a joint near standstill, F exp(-(v/vs)^2) sign v, that a fast enough motion washes away."""

from collections.abc import Mapping, Sequence

import numpy as np

from boom_mj.effects.effect import Array, Location, Parameter, Values
from boom_mj.effects.general_effect import ResistEffect, Typical

SHARP = 0.02  # of the Stribeck speed, within which the sign changes


class StribeckFriction(ResistEffect):
    """The extra friction of a joint near standstill, F exp(-(v/vs)^2) sign v, that a fast enough motion washes away.

    It comes on top of Coulomb friction. The speed is the measured one, also where commands drive the joint.
    """

    id = "stribeck_friction"
    confused_with = ("coulomb_friction",)
    told_by = "slow motions"

    @classmethod
    def sized(cls, typical: Typical) -> Mapping[str, Parameter]:
        fast, size = typical.speed, 0.1 * typical.value
        return {
            "excess": Parameter(typical.force_unit, 0.0, 0.0, 50 * size, size),
            "speed": Parameter(f"{typical.unit}/s", 0.1 * fast, 1e-3 * fast, fast, fast),
        }

    def resist(self, speed: Array, load: Array) -> Array:
        share = speed / self.values["speed"]
        return self.values["excess"] * np.exp(-(share**2)) * np.tanh(share / SHARP)

    @classmethod
    def probes(cls, location: Location, lines: Sequence[float] = ()) -> list[list[dict[str, float]]]:
        excess, speed = cls.parameters["excess"], cls.parameters["speed"]
        return [[{"excess": excess.typical, "speed": share * speed.typical}] for share in (0.03, 0.1, 0.3)]

    @classmethod
    def blend(cls, probes: Sequence[Values], weights: Array) -> dict[str, float]:
        knob = cls.parameters["excess"]
        return {"excess": knob.value(float(weights[0])), "speed": probes[0]["speed"]}
