"""Rotor inertia (or mass) of a joint's drive, reflected through its gears, beyond that of the model."""

from collections.abc import Mapping
from typing import Any

import mujoco

from boom_mj.effects import ModelEffect, Parameter, Site


class Armature(ModelEffect):
    """Rotor inertia (or mass) of a joint's drive, reflected through its gears, beyond that of the model."""

    id = "armature"
    at = ("joint",)
    needs = frozenset({"mjcf"})
    confused_with = ("body_mass", "payload", "actuator_gain", "series_compliance", "sprung_inertia")
    separating_experiment = "fast and slow accelerations"

    @classmethod
    def parameters(cls, site: Site) -> Mapping[str, Parameter]:
        unit, size = "kg" if site.unit == "m" else "kg m^2", 0.1 * site.inertia
        likely = (-site.armature / 2, 2 * site.inertia)  # drives are matched to what they move
        return {"inertia": Parameter(unit, 0.0, -site.armature, 200 * size, size, likely=likely)}

    def edit(self, spec: mujoco.MjSpec, machine: Any) -> None:
        spec.joint(str(self.location["joint"])).armature += self.values["inertia"]
