"""Elasticity of a link that is a chain of sprung joints."""

from collections.abc import Mapping

import mujoco

from boom_mj.effects.effect import Parameter
from boom_mj.effects.general_effect import SpecEffect, Typical
from boom_mj.effects.surgery import chain


class LinkStiffness(SpecEffect):
    """Elasticity of a flexible link by a factor: all sprung joints LINK/1, LINK/2, ... that stand for its bending."""

    id = "link_stiffness"
    where = "link"
    confused_with = ("body_mass", "payload", "sensor_scale")
    told_by = "free vibration, and a known static load"

    @classmethod
    def sized(cls, typical: Typical) -> Mapping[str, Parameter]:
        return {"factor": Parameter("", 1.0, 0.05, 20.0, 0.1)}

    def edit(self, spec: mujoco.MjSpec) -> None:
        for joint in chain(spec, self.name):
            joint.stiffness[0] *= self.values["factor"]
