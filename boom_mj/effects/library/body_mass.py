"""Mass and inertia of a body, by a factor."""

from collections.abc import Mapping
from typing import Any

import mujoco

from boom_mj.effects import ModelEffect, Parameter, Site
from boom_mj.effects.spec_edits import scale_mass


class BodyMass(ModelEffect):
    """Mass and inertia of a body, by a factor."""

    id = "body_mass"
    at = ("body",)
    needs = frozenset({"mjcf", "whole"})
    confused_with = ("payload", "armature", "actuator_gain", "joint_stiffness", "link_stiffness", "sensor_scale")
    separating_experiment = "static and dynamic forces together"

    @classmethod
    def parameters(cls, site: Site) -> Mapping[str, Parameter]:
        return {
            "factor": Parameter("1", 1.0, 0.1, 10.0, 0.1, likely=(0.7, 1.4))
        }  # screws and cables, not twice the part

    def edit(self, spec: mujoco.MjSpec, machine: Any) -> None:
        scale_mass(spec.body(str(self.location["body"])), self.values["factor"])
