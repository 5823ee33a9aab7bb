"""Friction of a joint whose viscous part differs between the directions."""

from collections.abc import Mapping, Sequence

import numpy as np

from boom_mj.effects import Array, Parameter, ResistEffect, Site

STANDSTILL = 0.02  # of the joint's rms speed, within which the dry part changes its sign


class DirectionalFriction(ResistEffect):
    """Dry friction of a joint and viscous friction that differs between the directions, F sign v + b(sign v) v.

    So screws, belts and seals behave; the speed is the measured one.
    """

    id = "directional_friction"
    special_cases = ("coulomb_friction", "viscous_joint_friction", "dry_and_viscous_friction")
    confused_with = ("dry_and_viscous_friction", "asymmetric_friction")
    separating_experiment = "slow and fast motions both ways"

    @classmethod
    def parameters(cls, site: Site) -> Mapping[str, Parameter]:
        size = max(0.1 * site.value / site.speed, 0.1 * site.damping)
        viscous = Parameter(f"{site.force_unit} s/{site.unit}", 0.0, -site.damping, 200 * size, size)
        dry = Parameter(site.force_unit, 0.0, 0.0, 20 * site.value, 0.1 * site.value)
        return {"force": dry, "forward": viscous, "backward": viscous}

    def resist(self, speed: Array, load: Array) -> Array:
        small = STANDSTILL * max(float(np.sqrt(np.mean(speed**2))), 1e-12)
        damping = np.where(speed > 0, self.values["forward"], self.values["backward"])
        return self.values["force"] * np.tanh(speed / small) + damping * speed

    @classmethod
    def screening(cls, site: Site, lines_hz: Sequence[float] = ()) -> list[list[dict[str, float]]]:
        """A mixture, each part with its own weight."""
        return [[{name: parameter.typical} for name, parameter in cls.parameters(site).items()]]
