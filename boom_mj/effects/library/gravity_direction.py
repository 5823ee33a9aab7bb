"""A base that does not stand upright."""

from collections.abc import Mapping
from typing import Any

import mujoco

from boom_mj.effects import ModelEffect, Parameter, Site
from boom_mj.effects.spec_edits import turn_gravity


class GravityDirection(ModelEffect):
    """A base that does not stand upright: gravity turned about x (roll) and y (pitch) of the model."""

    id = "gravity_direction"
    needs = frozenset({"mjcf", "heavy"})
    confused_with = ("actuator_bias", "sensor_offset", "joint_stiffness")
    separating_experiment = "poses all around"

    @classmethod
    def parameters(cls, site: Site) -> Mapping[str, Parameter]:
        tilt = Parameter("rad", 0.0, -0.1, 0.1, 0.02, likely=(-0.05, 0.05))  # 3 deg are seen
        return {"roll": tilt, "pitch": tilt}

    def edit(self, spec: mujoco.MjSpec, machine: Any) -> None:
        turn_gravity(spec, self.values["roll"], self.values["pitch"])
