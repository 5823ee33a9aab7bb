"""Mass and inertia of a body, by a factor."""

from collections.abc import Mapping

import mujoco

from boom_mj.effects.effect import Parameter
from boom_mj.effects.general_effect import SpecEffect, Typical
from boom_mj.effects.surgery import scale_mass


class BodyMass(SpecEffect):
    """Mass and inertia of a body, by a factor."""

    id = "body_mass"
    where = "body"
    needs = frozenset({"whole"})
    confused_with = ("payload", "armature", "actuator_gain", "joint_stiffness")
    told_by = "static and dynamic forces together"

    @classmethod
    def sized(cls, typical: Typical) -> Mapping[str, Parameter]:
        return {"factor": Parameter("", 1.0, 0.1, 10.0, 0.1)}

    def edit(self, spec: mujoco.MjSpec) -> None:
        scale_mass(spec.body(self.name), self.values["factor"])
