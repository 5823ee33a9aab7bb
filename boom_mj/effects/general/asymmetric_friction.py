"""Dry friction of a joint that differs between the directions."""

from collections.abc import Mapping

import mujoco

from boom_mj.effects.effect import Parameter
from boom_mj.effects.general_effect import SpecEffect, Typical
from boom_mj.effects.surgery import add_constant_force, add_friction


class AsymmetricFriction(SpecEffect):
    """Dry friction of a joint that differs between the directions.

    With levels F+ and F- it is the same as friction (F+ + F-)/2 and a constant force -(F+ - F-)/2, sticking included.
    """

    id = "asymmetric_friction"
    where = "joint"
    sizes = (0.3, 1.0, 3.0)
    special_cases = ("coulomb_friction",)
    confused_with = ("coulomb_friction", "actuator_bias")
    told_by = "motions both ways"

    @classmethod
    def sized(cls, typical: Typical) -> Mapping[str, Parameter]:
        knob = Parameter(typical.force_unit, 0.0, 0.0, 20 * typical.value, 0.1 * typical.value)
        return {"forward": knob, "backward": knob}

    def edit(self, spec: mujoco.MjSpec) -> None:
        forward, backward = self.values["forward"], self.values["backward"]
        add_friction(spec, self.name, (forward + backward) / 2)
        if forward != backward:
            add_constant_force(spec, self.name, -(forward - backward) / 2)
