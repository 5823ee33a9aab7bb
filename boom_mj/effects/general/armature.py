"""Rotor inertia (or mass) of a joint's drive, reflected through its gears, beyond that of the model."""

from collections.abc import Mapping

import mujoco

from boom_mj.effects.effect import Parameter
from boom_mj.effects.general_effect import SpecEffect, Typical


class Armature(SpecEffect):
    """Rotor inertia (or mass) of a joint's drive, reflected through its gears, beyond that of the model."""

    id = "armature"
    where = "joint"
    confused_with = ("body_mass", "payload", "actuator_gain")
    told_by = "fast and slow accelerations"

    @classmethod
    def sized(cls, typical: Typical) -> Mapping[str, Parameter]:
        unit, size = "kg" if typical.unit == "m" else "kg m^2", 0.1 * typical.inertia
        return {"inertia": Parameter(unit, 0.0, -typical.armature, 200 * size, size)}

    def edit(self, spec: mujoco.MjSpec) -> None:
        spec.joint(self.name).armature += self.values["inertia"]
