"""A link softer or stiffer than its drawing."""

import mujoco

from boom_mj.effects.effect import ModelEffect, Parameter
from boom_mj.effects.structure import link_hinges
from boom_mj.machine import Machine


class LinkStiffness(ModelEffect):
    """Every modulus of one deformation of a link times a factor; its Kelvin-Voigt damping goes with it."""

    id = "link_stiffness"
    places = {"link": (2, 3, 4, 5), "axis": ("v", "w", "torsion")}
    parameters = {"factor": Parameter("1", 1.0, 0.2, 5.0, -0.1)}
    confused_with = ("link_stiffness of the neighbour", "hydraulic_compliance", "base_compliance", "slew_compliance")
    told_by = "release_bow_vertical"
    sizes = (1.0, -1.0)

    def edit(self, spec: mujoco.MjSpec, machine: Machine) -> None:
        for hinge in link_hinges(spec, int(self.location["link"]), str(self.location["axis"])):
            hinge.stiffness = hinge.stiffness * self.values["factor"]
            hinge.damping = hinge.damping * self.values["factor"]
