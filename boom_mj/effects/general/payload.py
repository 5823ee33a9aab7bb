"""A mass at the end of a body."""

from collections.abc import Mapping

import mujoco

from boom_mj.effects.effect import Parameter
from boom_mj.effects.general_effect import SpecEffect, Typical
from boom_mj.effects.surgery import add_mass


class Payload(SpecEffect):
    """A mass at the end of a body: at its site `payload`, `tip` or `attachment_site`, or its centre of mass."""

    id = "payload"
    where = "body"
    needs = frozenset({"leaf"})
    confused_with = ("body_mass",)
    told_by = "static forces in several poses"

    @classmethod
    def sized(cls, typical: Typical) -> Mapping[str, Parameter]:
        return {"mass": Parameter("kg", 0.0, 0.0, 20 * typical.mass, 0.1 * typical.mass)}

    def edit(self, spec: mujoco.MjSpec) -> None:
        if self.values["mass"]:
            add_mass(spec, self.name, self.values["mass"])
