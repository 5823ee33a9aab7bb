"""Viscous friction of a joint."""

from collections.abc import Mapping
from typing import Any

import mujoco

from boom_mj.effects import ModelEffect, Parameter, Site


class ViscousJointFriction(ModelEffect):
    """Viscous friction of a joint: a force in proportion to its speed, beyond (or below) that of the model."""

    id = "viscous_joint_friction"
    at = ("joint",)
    needs = frozenset({"mjcf"})
    confused_with = ("coulomb_friction", "quadratic_damping", "dry_and_viscous_friction", "link_damping")
    separating_experiment = "slow and fast motions"

    @classmethod
    def parameters(cls, site: Site) -> Mapping[str, Parameter]:
        size = max(0.1 * site.value / site.speed, 0.1 * site.damping)
        unit = site.force_unit + f" s/{site.unit}"
        return {"damping": Parameter(unit, 0.0, -site.damping, 200 * size, size)}

    def edit(self, spec: mujoco.MjSpec, machine: Any) -> None:
        joint = spec.joint(str(self.location["joint"]))
        joint.damping[0] += self.values["damping"]
