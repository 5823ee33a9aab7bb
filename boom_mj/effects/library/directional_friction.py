"""Friction of a joint whose viscous part differs between the directions."""

from collections.abc import Mapping, Sequence
from typing import Any

import mujoco

from boom_mj.effects import Array, ModelEffect, Parameter, ResistEffect, Site
from boom_mj.effects.spec_edits import add_friction


class DirectionalFriction(ModelEffect, ResistEffect):
    """Dry friction of a joint and viscous friction that differs between the directions, F sign v + b(sign v) v.

    So screws, belts and seals behave. What both directions have in common is the model's, so that the joint sticks;
    the difference, (b+ - b-)/2 |v|, follows the measured speed.
    """

    id = "directional_friction"
    special_cases = ("coulomb_friction", "viscous_joint_friction", "dry_and_viscous_friction")
    confused_with = ("dry_and_viscous_friction", "asymmetric_friction")
    separating_experiment = "slow and fast motions both ways"

    @classmethod
    def parameters(cls, site: Site) -> Mapping[str, Parameter]:
        size = max(0.1 * site.value / site.speed, 0.1 * site.damping)
        viscous = Parameter(f"{site.force_unit} s/{site.unit}", 0.0, -site.damping, 200 * size, size)
        dry = Parameter(site.force_unit, 0.0, -site.friction, 20 * site.value, 0.1 * site.value)
        return {"force": dry, "forward": viscous, "backward": viscous}

    def edit(self, spec: mujoco.MjSpec, machine: Any) -> None:
        add_friction(spec, joint := str(self.location["joint"]), self.values["force"])
        spec.joint(joint).damping[0] += (self.values["forward"] + self.values["backward"]) / 2

    def resist(self, speed: Array, load: Array) -> Array:
        return (self.values["forward"] - self.values["backward"]) / 2 * abs(speed)

    @classmethod
    def screening(cls, site: Site, lines_hz: Sequence[float] = ()) -> list[list[dict[str, float]]]:
        """A mixture, each part with its own weight."""
        force, *ways = ({name: parameter.typical} for name, parameter in cls.parameters(site).items())
        return [[{"force": size * force["force"]}, *ways] for size in (1.0, 3.0, 10.0)]
