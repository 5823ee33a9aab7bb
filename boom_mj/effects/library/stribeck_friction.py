"""The extra friction of a joint near standstill, F exp(-(v/vs)^2) sign v, that a fast enough motion washes away."""

from collections.abc import Mapping, Sequence
from typing import Any

import mujoco
import numpy as np

from boom_mj.effects import Array, ModelEffect, Parameter, ResistEffect, Site, Values
from boom_mj.effects.spec_edits import add_friction


class StribeckFriction(ModelEffect, ResistEffect):
    """The extra friction of a joint near standstill, F exp(-(v/vs)^2) sign v, that a fast enough motion washes away.

    It comes on top of Coulomb friction. The model has all of it as dry friction, so that the joint sticks; what is
    washed away follows the measured speed, also where commands drive the joint.
    """

    id = "stribeck_friction"
    confused_with = ("coulomb_friction", "dry_and_viscous_friction")
    separating_experiment = "slow motions"
    shapes = frozenset({"speed"})

    @classmethod
    def parameters(cls, site: Site) -> Mapping[str, Parameter]:
        fast, size = site.speed, 0.1 * site.value
        return {
            "excess": Parameter(site.force_unit, 0.0, 0.0, 50 * size, size),
            "speed": Parameter(f"{site.unit}/s", 0.1 * fast, 1e-3 * fast, fast, fast),
        }

    def edit(self, spec: mujoco.MjSpec, machine: Any) -> None:
        add_friction(spec, str(self.location["joint"]), self.values["excess"])

    def resist(self, speed: Array, load: Array) -> Array:
        return self.values["excess"] * np.expm1(-((speed / self.values["speed"]) ** 2)) * np.sign(speed)

    @classmethod
    def screening(cls, site: Site, lines_hz: Sequence[float] = ()) -> list[list[dict[str, float]]]:
        excess, speed = cls.parameters(site).values()
        return [[{"excess": excess.typical, "speed": share * speed.typical}] for share in (0.03, 0.1, 0.3)]

    @classmethod
    def combine(cls, site: Site, points: Sequence[Values], weights: Array) -> dict[str, float]:
        excess = cls.parameters(site)["excess"]
        return {"excess": excess.value(float(weights[0])), "speed": points[0]["speed"]}
