"""Mass of a link that is a chain of bodies."""

from collections.abc import Mapping
from typing import Any

import mujoco

from boom_mj.effects import ModelEffect, Parameter, Site
from boom_mj.effects.spec_edits import chain, scale_mass


class LinkDensity(ModelEffect):
    """Mass and inertia of a flexible link by a factor: all bodies behind its joints LINK/1, LINK/2, ..."""

    id = "link_density"
    at = ("link",)
    needs = frozenset({"mjcf"})
    confused_with = ("link_stiffness", "payload")
    separating_experiment = "a scale"

    @classmethod
    def parameters(cls, site: Site) -> Mapping[str, Parameter]:
        return {"factor": Parameter("1", 1.0, 0.1, 10.0, 0.1, likely=(0.7, 1.4))}  # of the same material

    def edit(self, spec: mujoco.MjSpec, machine: Any) -> None:
        for joint in chain(spec, str(self.location["link"])):
            scale_mass(joint.parent, self.values["factor"])
