"""A slewing gear that gives."""

import mujoco
import numpy as np

from boom_mj.effects import DETUNING, ModelEffect, Parameter
from boom_mj.effects.library.hydraulic_compliance import add_spring
from boom_mj.machine import Machine


class SlewCompliance(ModelEffect):
    """A spring between the slewing sensor (drive side) and the turret."""

    id = "slew_compliance"
    needs = frozenset({"boom"})
    table = {"stiffness": Parameter("N m/rad", np.inf, 1e5, np.inf, 5e7, inverse=True)}
    confused_with = ("slew_backlash", "base_compliance", "link_stiffness")
    separating_experiment = "slew_t"
    sizes = DETUNING

    def edit(self, spec: mujoco.MjSpec, machine: Machine) -> None:
        add_spring(spec, machine, 1, "joint1_spring", self.values["stiffness"])
