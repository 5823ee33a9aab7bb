"""Dry friction of a joint."""

from collections.abc import Mapping
from typing import Any

import mujoco

from boom_mj.effects import ModelEffect, Parameter, Site
from boom_mj.effects.spec_edits import add_friction


class CoulombFriction(ModelEffect):
    """Dry friction of a joint: a force of constant size against the motion, that holds what does not move.

    MuJoCo's `frictionloss`, with a stiff friction constraint so that it creeps little.
    """

    id = "coulomb_friction"
    at = ("joint",)
    needs = frozenset({"mjcf"})
    sizes = (0.3, 1.0, 3.0, 10.0)
    confused_with = (
        "viscous_joint_friction",
        "load_friction",
        "asymmetric_friction",
        "backlash",
        "dead_zone",
        "dry_and_viscous_friction",
        "link_damping",
        "stribeck_friction",
        "friction_behind_play",
    )
    separating_experiment = "slow and fast motions"

    @classmethod
    def parameters(cls, site: Site) -> Mapping[str, Parameter]:
        return {"force": Parameter(site.force_unit, 0.0, -site.friction, 20 * site.value, 0.1 * site.value)}

    def edit(self, spec: mujoco.MjSpec, machine: Any) -> None:
        add_friction(spec, str(self.location["joint"]), self.values["force"])
