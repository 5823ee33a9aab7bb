"""A link heavier or lighter than its drawing."""

import mujoco

from boom_mj.effects.effect import ModelEffect, Parameter
from boom_mj.effects.structure import link_bodies
from boom_mj.machine import Machine


class LinkMass(ModelEffect):
    """All masses of a link, attached components included, times a factor; its centre of gravity stays."""

    id = "link_mass"
    places = {"link": (2, 3, 4, 5)}
    parameters = {"factor": Parameter("1", 1.0, 0.2, 5.0, 0.1)}
    confused_with = ("tip_payload", "pipe_concrete", "pressure_scale")
    told_by = "sweep"

    def edit(self, spec: mujoco.MjSpec, machine: Machine) -> None:
        for body in link_bodies(spec, int(self.location["link"])):
            body.mass = body.mass * self.values["factor"]
            body.fullinertia = body.fullinertia * self.values["factor"]
