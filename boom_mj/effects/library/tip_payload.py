"""A mass on the boom's tip."""

import mujoco

from boom_mj.effects import DETUNING, ModelEffect, Parameter
from boom_mj.effects.spec_edits import add_point_mass
from boom_mj.machine import Machine


class TipPayload(ModelEffect):
    """A rigid mass at the tip: more sag, lower frequencies, cylinder forces in the ratio of their levers."""

    id = "tip_payload"
    needs = frozenset({"boom"})
    table = {"mass": Parameter("kg", 0.0, 0.0, 1000.0, 40.0)}
    confused_with = ("pipe_concrete", "link_mass", "link_stiffness", "end_hose")
    separating_experiment = "release_bow_vertical"
    sizes = DETUNING

    def edit(self, spec: mujoco.MjSpec, machine: Machine) -> None:
        if mass := self.values["mass"]:
            add_point_mass(spec.site("tip"), "payload", mass)
