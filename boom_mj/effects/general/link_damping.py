"""Material damping of a link that is a chain of sprung joints."""

from collections.abc import Mapping

import mujoco

from boom_mj.effects.effect import Parameter
from boom_mj.effects.general_effect import SpecEffect, Typical
from boom_mj.effects.surgery import chain


class LinkDamping(SpecEffect):
    """Material damping of a flexible link, in proportion to its stiffness: relaxation time on top of the model's."""

    id = "link_damping"
    where = "link"
    confused_with = ("viscous_friction", "coulomb_friction", "quadratic_damping")
    told_by = "free vibration of several sizes"

    @classmethod
    def sized(cls, typical: Typical) -> Mapping[str, Parameter]:
        return {"relaxation_time": Parameter("s", 0.0, 0.0, 1.0, 0.001)}

    def edit(self, spec: mujoco.MjSpec) -> None:
        for joint in chain(spec, self.name):
            joint.damping[0] += self.values["relaxation_time"] * joint.stiffness[0]
