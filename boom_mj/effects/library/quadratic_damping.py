"""Drag of a joint that grows with the square of its speed, against the motion."""

from collections.abc import Mapping
from typing import Any

import mujoco

from boom_mj.effects import ModelEffect, Parameter, Site


class QuadraticDamping(ModelEffect):
    """Drag of a joint that grows with the square of its speed, against the motion.

    MuJoCo's polynomial damping, f = b v |v|; a negative one would push at high speed.
    """

    id = "quadratic_damping"
    at = ("joint",)
    needs = frozenset({"mjcf"})
    confused_with = ("viscous_joint_friction", "link_damping")
    separating_experiment = "motions at several speeds"

    @classmethod
    def parameters(cls, site: Site) -> Mapping[str, Parameter]:
        size = 0.1 * site.value / site.speed**2
        unit = site.force_unit + f" s^2/{site.unit}^2"
        return {"drag": Parameter(unit, 0.0, 0.0, 100 * size, size)}

    def edit(self, spec: mujoco.MjSpec, machine: Any) -> None:
        joint = spec.joint(str(self.location["joint"]))
        joint.damping[1] += self.values["drag"]
