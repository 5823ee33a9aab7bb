"""Friction of a joint as textbooks have it, dry and viscous together."""

from collections.abc import Mapping, Sequence
from typing import Any

import mujoco

from boom_mj.effects import ModelEffect, Parameter, Site
from boom_mj.effects.spec_edits import add_friction


class DryAndViscousFriction(ModelEffect):
    """Dry and viscous friction of a joint together: a force that does not vanish at rest, and grows with the speed.

    A nominal model that was given all of its friction as viscous needs more of the one and less of the other at once:
    neither alone helps.
    """

    id = "dry_and_viscous_friction"
    at = ("joint",)
    needs = frozenset({"mjcf"})
    special_cases = ("coulomb_friction", "viscous_joint_friction")
    confused_with = (
        "coulomb_friction",
        "viscous_joint_friction",
        "stribeck_friction",
        "dead_zone",
        "sprung_inertia",
        "directional_friction",
    )
    separating_experiment = "slow and fast motions"

    @classmethod
    def parameters(cls, site: Site) -> Mapping[str, Parameter]:
        size = max(0.1 * site.value / site.speed, 0.1 * site.damping)
        unit = site.force_unit + f" s/{site.unit}"
        return {
            "force": Parameter(site.force_unit, 0.0, -site.friction, 20 * site.value, 0.1 * site.value),
            "damping": Parameter(unit, 0.0, -site.damping, 200 * size, size),
        }

    def edit(self, spec: mujoco.MjSpec, machine: Any) -> None:
        add_friction(spec, str(self.location["joint"]), self.values["force"])
        spec.joint(str(self.location["joint"])).damping[0] += self.values["damping"]

    @classmethod
    def screening(cls, site: Site, lines_hz: Sequence[float] = ()) -> list[list[dict[str, float]]]:
        """A mixture: both at once, each with its own weight."""
        return [
            [
                {"force": size * cls.parameters(site)["force"].typical},
                {"damping": cls.parameters(site)["damping"].typical},
            ]
            for size in (1.0, 3.0, 10.0)
        ]
