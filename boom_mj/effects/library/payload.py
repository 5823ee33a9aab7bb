"""A mass at the end of a body."""

from collections.abc import Mapping
from typing import Any

import mujoco

from boom_mj.effects import ModelEffect, Parameter, Site
from boom_mj.effects.spec_edits import add_mass


class Payload(ModelEffect):
    """A mass at the end of a body: at its site `payload`, `tip` or `attachment_site`, or its centre of mass."""

    id = "payload"
    at = ("body",)
    needs = frozenset({"mjcf", "leaf"})
    confused_with = ("body_mass", "armature", "link_density", "link_stiffness", "relaxing_stiffness")
    separating_experiment = "static forces in several poses"

    @classmethod
    def parameters(cls, site: Site) -> Mapping[str, Parameter]:
        return {"mass": Parameter("kg", 0.0, 0.0, 20 * site.mass, 0.1 * site.mass)}

    def edit(self, spec: mujoco.MjSpec, machine: Any) -> None:
        if self.values["mass"]:
            add_mass(spec, str(self.location["body"]), self.values["mass"])
