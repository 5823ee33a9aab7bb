"""A link bent by the sun."""

from itertools import pairwise

import mujoco

from boom_mj.effects import ModelEffect, Parameter
from boom_mj.effects.spec_edits import link_hinges
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
        link = int(self.location["link"])
        hinges = link_hinges(spec, link, str(self.location["axis"]))
        at = [float(hinge.pos[0]) for hinge in hinges]
        edges = [-machine.links[link - 2].length, *((a + b) / 2 for a, b in pairwise(at)), 0.0]
        lever = sum(-x * (stop - start) for x, (start, stop) in zip(at, pairwise(edges)))
        for hinge, (start, stop) in zip(hinges, pairwise(edges)):
            hinge.springref = hinge.springref + self.values["displacement"] / lever * (stop - start)
