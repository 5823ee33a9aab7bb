"""Friction of a joint as textbooks have it, dry and viscous together."""

from collections.abc import Mapping, Sequence

import mujoco

from boom_mj.effects.effect import Location, Parameter
from boom_mj.effects.general_effect import SpecEffect, Typical
from boom_mj.effects.surgery import add_friction


class JointFriction(SpecEffect):
    """Dry and viscous friction of a joint together: a force that does not vanish at rest, and grows with the speed.

    A nominal model that was given all of its friction as viscous needs more of the one and less of the other at once:
    neither alone helps.
    """

    id = "joint_friction"
    where = "joint"
    special_cases = ("coulomb_friction", "viscous_friction")
    confused_with = ("coulomb_friction", "viscous_friction", "stribeck_friction", "dead_zone")
    told_by = "slow and fast motions"

    @classmethod
    def sized(cls, typical: Typical) -> Mapping[str, Parameter]:
        size = max(0.1 * typical.value / typical.speed, 0.1 * typical.damping)
        unit = typical.force_unit + f" s/{typical.unit}"
        return {
            "force": Parameter(typical.force_unit, 0.0, 0.0, 20 * typical.value, 0.1 * typical.value),
            "damping": Parameter(unit, 0.0, -typical.damping, 200 * size, size),
        }

    def edit(self, spec: mujoco.MjSpec) -> None:
        add_friction(spec, self.name, self.values["force"])
        spec.joint(self.name).damping[0] += self.values["damping"]

    @classmethod
    def probes(cls, location: Location, lines: Sequence[float] = ()) -> list[list[dict[str, float]]]:
        """A mixture: both at once, each with its own weight."""
        return [
            [{"force": size * cls.parameters["force"].typical}, {"damping": cls.parameters["damping"].typical}]
            for size in (1.0, 3.0)
        ]
