"""Viscous friction of a joint."""

import mujoco

from boom_mj.effects import ModelEffect, Parameter
from boom_mj.machine import Machine


class ViscousFriction(ModelEffect):
    """The drive pushes against a torque in proportion to the joint's rate, by a factor of what the machine file says.

    Joints follow their path whatever it costs, so that only the cylinders of joints 2 and 3 feel it.
    """

    id = "viscous_friction"
    at = ("joint",)
    needs = frozenset({"boom", "cylinder"})
    table = {"factor": Parameter("1", 1.0, 0.0, 30.0, 2.0)}
    confused_with = ("joint_friction", "pressure_scale")
    separating_experiment = "sweep"

    def edit(self, spec: mujoco.MjSpec, machine: Machine) -> None:
        spec.joint(f"joint{self.location['joint']}").damping[0] *= self.values["factor"]
