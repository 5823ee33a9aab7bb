"""Outriggers that give."""

import mujoco
import numpy as np

from boom_mj.effects import DETUNING, ModelEffect, Parameter, Site
from boom_mj.effects.spec_edits import spring_base
from boom_mj.machine import Machine


class BaseCompliance(ModelEffect):
    """The whole machine rolls (about x) or pitches (about y) on springs at the origin, seen from the ground."""

    id = "base_compliance"
    at = ("axes",)
    needs = frozenset({"boom"})
    table = {
        "roll": Parameter("N m/rad", np.inf, 1e6, np.inf, 3e8, inverse=True),
        "pitch": Parameter("N m/rad", np.inf, 1e6, np.inf, 3e8, inverse=True),
    }
    confused_with = ("hydraulic_compliance", "slew_compliance", "link_stiffness", "camera_pose")
    separating_experiment = "slew_tour"
    sizes = DETUNING

    @classmethod
    def free(cls, site: Site) -> tuple[str, ...]:
        return tuple(str(site.location["axes"]).split("+"))

    def edit(self, spec: mujoco.MjSpec, machine: Machine) -> None:
        for axis, stiffness in self.values.items():
            if np.isfinite(stiffness):
                spring_base(spec, machine, axis, stiffness)
