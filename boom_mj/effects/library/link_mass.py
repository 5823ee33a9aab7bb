"""A link heavier or lighter than its drawing."""

import mujoco
import numpy as np

from boom_mj.effects import Array, ModelEffect, Parameter
from boom_mj.effects.spec_edits import second_moment, set_second_moment, stretches
from boom_mj.machine import Machine


class LinkMass(ModelEffect):
    """The mass of a link that its drawing tells, times a factor; actuators at its joints keep theirs."""

    id = "link_mass"
    at = ("link",)
    needs = frozenset({"boom"})
    table = {"factor": Parameter("1", 1.0, 0.2, 5.0, 0.1)}
    confused_with = ("tip_payload", "pipe_concrete", "pressure_scale", "link_length")
    separating_experiment = "sweep"
    sizes = (1.0, -1.0)

    def edit(self, spec: mujoco.MjSpec, machine: Machine) -> None:
        number, factor = int(self.location["link"]), self.values["factor"]
        if factor == 1:
            return
        link, actuators = machine.links[number - 2], machine.masses_on_link[number - 2]
        slope = link.offset / link.length if machine.offset_profile.kind == "ramp" else 0.0
        for body, start, stop in stretches(spec, machine, number):
            there = [(x, mass) for x, mass in actuators if start <= x < stop or x == stop == 0]
            parts = [(1 - factor, mass, np.array([x, 0.0, slope * x]), np.zeros((3, 3))) for x, mass in there]
            _set_sum(body, [(factor, body.mass, np.array(body.ipos), second_moment(body)), *parts])


def _set_sum(body: mujoco.MjsBody, parts: list[tuple[float, float, Array, Array]]) -> None:
    """A body of parts (factor, mass, centre, second moment about it); what is taken away counts as negative."""
    mass = sum(factor * m for factor, m, _, _ in parts)
    center = np.sum([factor * m * c for factor, m, c, _ in parts], axis=0) / mass
    spread = np.sum([f * (own + m * np.outer(c - center, c - center)) for f, m, c, own in parts], axis=0)
    body.mass, body.ipos = mass, center
    set_second_moment(body, spread)
