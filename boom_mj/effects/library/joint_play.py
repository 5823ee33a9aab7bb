"""Play in a joint's linkage."""

import mujoco

from boom_mj.effects import ModelEffect, Parameter
from boom_mj.effects.spec_edits import add_series_hinge
from boom_mj.machine import Machine
from boom_mj.machine.statics import outboard_load

GIVES = 5e-4  # rad, by which a flank gives to the stretched boom's weight: steel, a tenth of what oil gives
CENTRE = 1e2  # N m/rad, so that an unloaded joint has a rest
RATE = 130.0  # rad/s, of a flank and the armature of what moves in the gap: stable at steps of 10 ms
DAMPING_RATIO = 0.03
GRAVITY = 9.81  # m/s^2


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
        add_gap(spec, machine, joint, f"joint{joint}_play", self.values["half_gap"])


def flank_stiffness(machine: Machine, joint: int) -> float:
    """Of the gap of a joint, N m/rad."""
    return outboard_load(machine, max(joint, 2) - 3, GRAVITY).moment / GIVES


def add_gap(spec: mujoco.MjSpec, machine: Machine, joint: int, name: str, half_gap: float) -> None:
    """A series hinge that turns freely within +-half_gap (rad) and meets stiff flanks there."""
    hinge, stiffness = add_series_hinge(spec, joint, name), flank_stiffness(machine, joint)
    hinge.stiffness[0] = CENTRE
    hinge.armature, hinge.damping[0] = stiffness / RATE**2, 2 * DAMPING_RATIO * stiffness / RATE
    flanks = spec.add_tendon(name=name)
    flanks.wrap_joint(name, 1.0)
    flanks.springlength = [-half_gap, half_gap]
    flanks.stiffness[0] = stiffness
