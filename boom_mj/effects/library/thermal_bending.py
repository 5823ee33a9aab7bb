"""A link bent by the sun."""

from itertools import pairwise

import mujoco

from boom_mj.effects.effect import ModelEffect, Parameter
from boom_mj.effects.structure import link_hinges
from boom_mj.machine import Machine


class ThermalBending(ModelEffect):
    """A constant curvature without stress: springs rest bent so that the tip lies off by the displacement."""

    id = "thermal_bending"
    places = {"link": (2, 3, 4, 5), "axis": ("v", "w")}
    parameters = {"displacement": Parameter("m", 0.0, -0.5, 0.5, 0.02)}
    confused_with = ("wind", "joint zero offsets", "imu_misalignment")
    told_by = "slew_tour"

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
