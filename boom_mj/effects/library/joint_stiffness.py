"""Spring of a joint about its reference, beyond (or below) that of the model."""

from collections.abc import Mapping
from typing import Any

import mujoco

from boom_mj.effects import ModelEffect, Parameter, Site


class JointStiffness(ModelEffect):
    """Spring of a joint about its reference, beyond (or below) that of the model: flexible links, cables, hoses."""

    id = "joint_stiffness"
    at = ("joint",)
    needs = frozenset({"mjcf"})
    confused_with = ("body_mass", "gravity_direction", "sensor_scale", "relaxing_stiffness")
    separating_experiment = "free vibration, and a known static load"

    @classmethod
    def parameters(cls, site: Site) -> Mapping[str, Parameter]:
        size = max(0.1 * site.stiffness, 0.1 * site.value / site.span)
        unit = f"{site.force_unit}/{site.unit}"
        return {"stiffness": Parameter(unit, 0.0, -0.98 * site.stiffness, 50 * size, size)}

    def edit(self, spec: mujoco.MjSpec, machine: Any) -> None:
        joint = spec.joint(str(self.location["joint"]))
        joint.stiffness[0] += self.values["stiffness"]
