"""Viscous friction of a joint."""

from collections.abc import Mapping

import mujoco

from boom_mj.effects.effect import Parameter
from boom_mj.effects.general_effect import SpecEffect, Typical


class ViscousFriction(SpecEffect):
    """Viscous friction of a joint: a force in proportion to its speed, beyond (or below) that of the model."""

    id = "viscous_friction"
    where = "joint"
    confused_with = ("coulomb_friction", "quadratic_damping")
    told_by = "slow and fast motions"

    @classmethod
    def sized(cls, typical: Typical) -> Mapping[str, Parameter]:
        size = max(0.1 * typical.value / typical.speed, 0.1 * typical.damping)
        unit = typical.force_unit + f" s/{typical.unit}"
        return {"damping": Parameter(unit, 0.0, -typical.damping, 200 * size, size)}

    def edit(self, spec: mujoco.MjSpec) -> None:
        joint = spec.joint(self.name)
        joint.damping[0] += self.values["damping"]
