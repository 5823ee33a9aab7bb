"""Mass of a link that is a chain of bodies."""

from collections.abc import Mapping

import mujoco

from boom_mj.effects.effect import Parameter
from boom_mj.effects.general_effect import SpecEffect, Typical
from boom_mj.effects.surgery import chain, scale_mass


class LinkDensity(SpecEffect):
    """Mass and inertia of a flexible link by a factor: all bodies behind its joints LINK/1, LINK/2, ..."""

    id = "link_density"
    where = "link"
    confused_with = ("link_stiffness", "payload")
    told_by = "a scale"

    @classmethod
    def sized(cls, typical: Typical) -> Mapping[str, Parameter]:
        return {"factor": Parameter("", 1.0, 0.1, 10.0, 0.1)}

    def edit(self, spec: mujoco.MjSpec) -> None:
        for joint in chain(spec, self.name):
            scale_mass(joint.parent, self.values["factor"])
