"""Play in a joint's linkage."""

import mujoco

from boom_mj.effects import ModelEffect, Parameter
from boom_mj.effects.spec_edits import add_series_hinge
from boom_mj.machine import Machine

STOP = 5e7  # N m/rad, stiffness of the flanks
CENTRE = 1e2  # N m/rad, so that an unloaded joint has a rest
ARMATURE = 1e3  # kg m^2 of the motion in the gap: the flanks stay stable at steps of 5 ms
DAMPING = 2e4  # N m s/rad


class JointPlay(ModelEffect):
    """Between the angle sensor (drive side) and the link lies a gap; weight keeps it at one flank until it reverses."""

    id = "joint_play"
    at = ("joint",)
    needs = frozenset({"boom", "linkage"})
    table = {"half_gap": Parameter("rad", 0.0, 0.0, 0.05, 0.003)}
    confused_with = ("joint_zero_offset", "joint_sensor_nonlinearity", "clock_offset")
    separating_experiment = "fold_in"

    def edit(self, spec: mujoco.MjSpec, machine: Machine) -> None:
        if self.values["half_gap"] == 0:
            return
        joint = int(self.location["joint"])
        add_gap(spec, joint, f"joint{joint}_play", self.values["half_gap"])


def add_gap(spec: mujoco.MjSpec, joint: int, name: str, half_gap: float) -> None:
    """A series hinge that turns freely within +-half_gap (rad) and meets stiff flanks there."""
    hinge = add_series_hinge(spec, joint, name)
    hinge.stiffness[0] = CENTRE
    hinge.armature, hinge.damping[0] = ARMATURE, DAMPING
    flanks = spec.add_tendon(name=name)
    flanks.wrap_joint(name, 1.0)
    flanks.springlength = [-half_gap, half_gap]
    flanks.stiffness[0] = STOP
