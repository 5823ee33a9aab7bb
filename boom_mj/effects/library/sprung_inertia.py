"""What an outermost sprung joint carries, with its spring, by one factor."""

from collections.abc import Mapping
from typing import Any

import mujoco

from boom_mj.effects import ModelEffect, Parameter, Site
from boom_mj.effects.spec_edits import scale_mass


class SprungInertia(ModelEffect):
    """What an outermost sprung joint carries, with its spring and damper, by one factor: it rings as before.

    How a flexible end rings and bends tells its inertia over its stiffness, never their size; that is felt where it is
    held. A nominal model that has the size wrong needs more of both at once: either alone puts it out of tune.
    """

    id = "sprung_inertia"
    at = ("joint",)
    needs = frozenset({"mjcf", "sprung", "outermost"})
    confused_with = ("armature", "dry_and_viscous_friction", "actuator_gain")
    separating_experiment = "the drive's force while the end rings"

    @classmethod
    def parameters(cls, site: Site) -> Mapping[str, Parameter]:
        return {"factor": Parameter("1", 1.0, 0.01, 100.0, 1.0, likely=(0.5, 2.0))}  # beyond it the drawing is another

    def edit(self, spec: mujoco.MjSpec, machine: Any) -> None:
        joint, factor = spec.joint(str(self.location["joint"])), self.values["factor"]
        joint.stiffness[0] *= factor
        joint.damping[0] *= factor
        joint.armature *= factor
        for body in (joint.parent, *joint.parent.find_all("body")):
            scale_mass(body, factor)
