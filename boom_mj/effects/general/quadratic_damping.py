"""Drag of a joint that grows with the square of its speed, against the motion."""

from collections.abc import Mapping

import mujoco

from boom_mj.effects.effect import Parameter
from boom_mj.effects.general_effect import SpecEffect, Typical


class QuadraticDamping(SpecEffect):
    """Drag of a joint that grows with the square of its speed, against the motion.

    MuJoCo's polynomial damping, f = b v |v|; a negative one would push at high speed.
    """

    id = "quadratic_damping"
    where = "joint"
    confused_with = ("viscous_friction",)
    told_by = "motions at several speeds"

    @classmethod
    def sized(cls, typical: Typical) -> Mapping[str, Parameter]:
        size = 0.1 * typical.value / typical.speed**2
        unit = typical.force_unit + f" s^2/{typical.unit}^2"
        return {"drag": Parameter(unit, 0.0, 0.0, 100 * size, size)}

    def edit(self, spec: mujoco.MjSpec) -> None:
        joint = spec.joint(self.name)
        joint.damping[1] += self.values["drag"]
