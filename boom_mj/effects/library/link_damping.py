"""Material damping of a link that is a chain of sprung joints."""

from collections.abc import Mapping
from typing import Any

import mujoco

from boom_mj.effects import ModelEffect, Parameter, Site
from boom_mj.effects.spec_edits import chain


class LinkDamping(ModelEffect):
    """Material damping of a flexible link, in proportion to its stiffness: relaxation time on top of the model's."""

    id = "link_damping"
    at = ("link",)
    needs = frozenset({"mjcf"})
    confused_with = (
        "viscous_joint_friction",
        "coulomb_friction",
        "quadratic_damping",
        "second_order_low_pass",
        "relaxing_stiffness",
    )
    separating_experiment = "free vibration of several sizes"

    @classmethod
    def parameters(cls, site: Site) -> Mapping[str, Parameter]:
        return {"relaxation_time": Parameter("s", 0.0, 0.0, 1.0, 0.001)}

    def edit(self, spec: mujoco.MjSpec, machine: Any) -> None:
        for joint in chain(spec, str(self.location["link"])):
            joint.damping[0] += self.values["relaxation_time"] * joint.stiffness[0]
