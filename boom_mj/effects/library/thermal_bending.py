"""A link bent by the sun."""

import mujoco
import numpy as np

from boom_mj.effects import ModelEffect, Parameter
from boom_mj.effects.spec_edits import bent_by
from boom_mj.machine import Machine


class ThermalBending(ModelEffect):
    """A constant curvature without stress: springs rest bent so that the tip lies off by the displacement."""

    id = "thermal_bending"
    at = ("link", "axis")
    needs = frozenset({"boom", "bending"})
    table = {"displacement": Parameter("m", 0.0, -0.5, 0.5, 0.02)}
    confused_with = ("wind", "joint_zero_offset", "imu_misalignment", "marker_slip")
    separating_experiment = "slew_tour"

    def edit(self, spec: mujoco.MjSpec, machine: Machine) -> None:
        if self.values["displacement"] == 0:
            return
        number, axis = int(self.location["link"]), str(self.location["axis"])
        link, hinges = machine.links[number - 2], bent_by(spec, machine, number, axis)
        shares = np.array([length for _, length in hinges])
        if axis == "v" and link.support is not None:  # what is bent evenly between root and pin: L / 2, by loads L / 3
            shares[0] += (link.length + link.support) / 6
        angles = self.values["displacement"] * shares / -sum(h.pos[0] * share for (h, _), share in zip(hinges, shares))
        for (hinge, _), angle in zip(hinges, angles):
            hinge.springref += angle
