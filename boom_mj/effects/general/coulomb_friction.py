"""Dry friction of a joint."""

from collections.abc import Mapping

import mujoco

from boom_mj.effects.effect import Parameter
from boom_mj.effects.general_effect import SpecEffect, Typical
from boom_mj.effects.surgery import add_friction


class CoulombFriction(SpecEffect):
    """Dry friction of a joint: a force of constant size against the motion, that holds what does not move.

    MuJoCo's `frictionloss`, with a stiff friction constraint so that it creeps little.
    """

    id = "coulomb_friction"
    where = "joint"
    sizes = (0.3, 1.0, 3.0)
    confused_with = ("viscous_friction", "load_friction", "asymmetric_friction")
    told_by = "slow and fast motions"

    @classmethod
    def sized(cls, typical: Typical) -> Mapping[str, Parameter]:
        return {"force": Parameter(typical.force_unit, 0.0, 0.0, 20 * typical.value, 0.1 * typical.value)}

    def edit(self, spec: mujoco.MjSpec) -> None:
        add_friction(spec, self.name, self.values["force"])
