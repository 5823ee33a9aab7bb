"""Dry friction of a joint that differs between the directions."""

from collections.abc import Mapping
from typing import Any

import mujoco

from boom_mj.effects import ModelEffect, Parameter, Site
from boom_mj.effects.spec_edits import add_constant_force, add_friction


class AsymmetricFriction(ModelEffect):
    """Dry friction of a joint that differs between the directions.

    With levels F+ and F- it is the same as friction (F+ + F-)/2 and a constant force -(F+ - F-)/2, sticking included.
    """

    id = "asymmetric_friction"
    at = ("joint",)
    needs = frozenset({"mjcf"})
    sizes = (0.3, 1.0, 3.0, 10.0)
    special_cases = ("coulomb_friction",)
    confused_with = ("coulomb_friction", "actuator_bias", "directional_friction", "asymmetric_dead_zone")
    separating_experiment = "motions both ways"

    @classmethod
    def parameters(cls, site: Site) -> Mapping[str, Parameter]:
        knob = Parameter(site.force_unit, 0.0, -site.friction, 20 * site.value, 0.1 * site.value)
        return {"forward": knob, "backward": knob}

    def edit(self, spec: mujoco.MjSpec, machine: Any) -> None:
        forward, backward = self.values["forward"], self.values["backward"]
        add_friction(spec, str(self.location["joint"]), (forward + backward) / 2)
        if forward != backward:
            add_constant_force(spec, str(self.location["joint"]), -(forward - backward) / 2)
