"""A machine that stands aslant."""

import mujoco

from boom_mj.effects import ModelEffect, Parameter
from boom_mj.effects.spec_edits import tilt_base
from boom_mj.machine import Machine


class BaseTilt(ModelEffect):
    """Gravity and load tilt against the machine, rolled about x, then pitched about y; markers stay with it."""

    id = "base_tilt"
    needs = frozenset({"boom"})
    table = {
        "roll": Parameter("rad", 0.0, -0.3, 0.3, 0.005),
        "pitch": Parameter("rad", 0.0, -0.3, 0.3, 0.005),
    }
    confused_with = ("imu_misalignment", "joint_zero_offset", "imu_bias", "wind")
    separating_experiment = "slew_tour"

    def edit(self, spec: mujoco.MjSpec, machine: Machine) -> None:
        if any(self.values.values()):
            tilt_base(spec, **self.values)
