"""More or less damping than assumed."""

import mujoco

from boom_mj.effects import ModelEffect, Parameter
from boom_mj.effects.spec_edits import elastic_hinges
from boom_mj.machine import Machine


class StructuralDamping(ModelEffect):
    """Every elastic damping times a factor: the envelope of a decay stays exponential at any amplitude."""

    id = "structural_damping"
    needs = frozenset({"boom"})
    table = {"factor": Parameter("1", 1.0, 0.2, 10.0, 0.4)}
    confused_with = ("structural_hysteresis",)
    separating_experiment = "release_stretched_vertical_half"
    sizes = (1.0, -1.0)

    def edit(self, spec: mujoco.MjSpec, machine: Machine) -> None:
        for hinge in elastic_hinges(spec, machine):
            hinge.damping = hinge.damping * self.values["factor"]
