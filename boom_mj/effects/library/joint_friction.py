"""Friction of a cylinder's seals."""

from collections.abc import Mapping

import numpy as np

from boom_mj.effects import OutputEffect, Parameter
from boom_mj.machine import Machine, cylinder_lengths
from boom_mj.recording import Signal, named_signal

CREEP = 2e-4  # m/s, the rate over which friction changes sign


class JointFriction(OutputEffect):
    """Coulomb friction between piston and pressure sensor: the motion does not change, the force has a hysteresis."""

    id = "joint_friction"
    at = ("joint",)
    needs = frozenset({"boom", "cylinder"})
    table = {"cylinder_force": Parameter("N", 0.0, 0.0, 1e5, 5e3)}
    confused_with = ("pressure_scale", "structural_hysteresis", "viscous_friction")
    separating_experiment = "sweep"

    def observe(self, signals: Mapping[str, Signal], machine: Machine) -> Mapping[str, Signal]:
        if self.values["cylinder_force"] == 0:
            return {}
        column = int(self.location["joint"]) - 2
        joints, force = signals["joint/position"], signals["cylinder/force"]
        rate = np.gradient(cylinder_lengths(machine, joints.values)[:, column], joints.time)
        values = force.values.copy()
        values[:, column] += self.values["cylinder_force"] * np.tanh(rate / CREEP)
        return {"cylinder/force": named_signal("cylinder/force", force.time, values)}
