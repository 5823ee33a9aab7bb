"""Oil that gives."""

import mujoco
import numpy as np

from boom_mj.effects import ModelEffect, Parameter
from boom_mj.effects.spec_edits import add_series_hinge
from boom_mj.machine import Machine


class HydraulicCompliance(ModelEffect):
    """A spring between the angle sensor (drive side) and the link that a cylinder moves."""

    id = "hydraulic_compliance"
    at = ("joint",)
    needs = frozenset({"boom", "cylinder"})
    table = {"stiffness": Parameter("N m/rad", np.inf, 1e5, np.inf, 3e7, inverse=True)}
    confused_with = ("link_stiffness", "base_compliance")
    separating_experiment = "chirp_joint2"

    def edit(self, spec: mujoco.MjSpec, machine: Machine) -> None:
        joint = int(self.location["joint"])
        add_spring(spec, machine, joint, f"joint{joint}_oil", self.values["stiffness"])


def add_spring(spec: mujoco.MjSpec, machine: Machine, joint: int, name: str, stiffness: float) -> None:
    """A damped spring (N m/rad) in series with a drive; none where it is infinite."""
    if np.isfinite(stiffness):
        hinge = add_series_hinge(spec, joint, name)
        hinge.stiffness[0], hinge.damping[0] = stiffness, machine.damping.relaxation_time * stiffness
