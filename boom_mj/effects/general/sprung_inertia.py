"""What an outermost sprung joint carries, with its spring, by one factor."""

from collections.abc import Mapping

import mujoco

from boom_mj.effects.effect import Parameter
from boom_mj.effects.general_effect import SpecEffect, Typical
from boom_mj.effects.surgery import scale_mass


class SprungInertia(SpecEffect):
    """What an outermost sprung joint carries, with its spring and damper, by one factor: it rings as before.

    How a flexible end rings and bends tells its inertia over its stiffness, never their size; that is felt where it is
    held. A nominal model that has the size wrong needs more of both at once: either alone puts it out of tune.
    """

    id = "sprung_inertia"
    where = "joint"
    needs = frozenset({"sprung", "outermost"})
    confused_with = ("armature", "joint_friction", "actuator_gain")
    told_by = "the drive's force while the end rings"

    @classmethod
    def sized(cls, typical: Typical) -> Mapping[str, Parameter]:
        return {"factor": Parameter("", 1.0, 0.01, 100.0, 1.0)}

    def edit(self, spec: mujoco.MjSpec) -> None:
        joint, factor = spec.joint(self.name), self.values["factor"]
        joint.stiffness[0] *= factor
        joint.damping[0] *= factor
        joint.armature *= factor
        for body in (joint.parent, *joint.parent.find_all("body")):
            scale_mass(body, factor)
