"""Concrete in the delivery pipe."""

import mujoco

from boom_mj.effects.effect import ModelEffect, Parameter
from boom_mj.effects.structure import stretches
from boom_mj.machine import Machine


class PipeConcrete(ModelEffect):
    """A line mass along all links, a fraction of `delivery_pipe.mass_per_length_concrete`."""

    id = "pipe_concrete"
    parameters = {"fill": Parameter("1", 0.0, 0.0, 1.5, 0.15)}
    confused_with = ("tip_payload", "link_mass")
    told_by = "release_bow_vertical"

    def edit(self, spec: mujoco.MjSpec, machine: Machine) -> None:
        density = self.values["fill"] * machine.delivery_pipe.mass_per_length_concrete
        if density == 0:
            return
        for link in range(2, 2 + len(machine.links)):
            for body, start, stop in stretches(spec, machine, link):
                mass, length = density * (stop - start), stop - start
                inertia = [1e-3 * mass, mass * length**2 / 12, mass * length**2 / 12]
                body.add_body(
                    name=f"concrete_{body.name}", pos=[(start + stop) / 2, 0, 0], mass=mass, inertia=inertia,
                    explicitinertial=True,
                )  # fmt: skip
