"""Backlash of the slewing gear."""

import mujoco
import numpy as np

from boom_mj.effects import ModelEffect, Parameter
from boom_mj.effects.library.joint_play import add_gap
from boom_mj.machine import Machine


class SlewBacklash(ModelEffect):
    """Between the slewing sensor (drive side) and the turret lies a gap: free around zero torque, then a jolt."""

    id = "slew_backlash"
    needs = frozenset({"boom"})
    table = {"half_gap": Parameter("rad", 0.0, 0.0, 0.05, 0.003)}
    confused_with = ("slew_compliance",)
    separating_experiment = "slew_t"
    sizes = (0.5, 1.5)
    grid_start = tuple(np.geomspace(0.3, 5.0, 9))  # every jolt turns the phase of what swings after it

    def edit(self, spec: mujoco.MjSpec, machine: Machine) -> None:
        if self.values["half_gap"]:
            add_gap(spec, machine, 1, "joint1_backlash", self.values["half_gap"])
