"""Spring of a joint about its reference, beyond (or below) that of the model."""

from collections.abc import Mapping

import mujoco

from boom_mj.effects.effect import Parameter
from boom_mj.effects.general_effect import SpecEffect, Typical


class JointStiffness(SpecEffect):
    """Spring of a joint about its reference, beyond (or below) that of the model: flexible links, cables, hoses."""

    id = "joint_stiffness"
    where = "joint"
    confused_with = ("body_mass", "gravity_direction")
    told_by = "free vibration, and a known static load"

    @classmethod
    def sized(cls, typical: Typical) -> Mapping[str, Parameter]:
        size = max(0.1 * typical.stiffness, 0.1 * typical.value / typical.span)
        unit = f"{typical.force_unit}/{typical.unit}"
        return {"stiffness": Parameter(unit, 0.0, -0.98 * typical.stiffness, 50 * size, size)}

    def edit(self, spec: mujoco.MjSpec) -> None:
        joint = spec.joint(self.name)
        joint.stiffness[0] += self.values["stiffness"]
