"""Concrete in the delivery pipe."""

import mujoco
import numpy as np

from boom_mj.effects import DETUNING, ModelEffect, Parameter
from boom_mj.effects.spec_edits import stretches
from boom_mj.machine import Machine

RADIUS = 0.03  # m, of gyration about the link


class PipeConcrete(ModelEffect):
    """A line mass along all links, a fraction of `delivery_pipe.mass_per_length_concrete`."""

    id = "pipe_concrete"
    needs = frozenset({"boom"})
    table = {"fill": Parameter("1", 0.0, 0.0, 1.5, 0.15)}
    confused_with = ("tip_payload", "link_mass")
    separating_experiment = "release_bow_vertical"
    sizes = DETUNING

    def edit(self, spec: mujoco.MjSpec, machine: Machine) -> None:
        density = self.values["fill"] * machine.delivery_pipe.mass_per_length_concrete
        if density == 0:
            return
        for link in range(2, 2 + len(machine.links)):
            for body, start, stop in stretches(spec, machine, link):
                length = stop - start
                concrete = body.add_body(name=f"concrete_{body.name}", explicitinertial=True)
                concrete.mass, concrete.ipos = density * length, [(start + stop) / 2, 0, 0]
                across = length**2 / 12 + RADIUS**2 / 2
                concrete.inertia = concrete.mass * np.array([RADIUS**2, across, across])
