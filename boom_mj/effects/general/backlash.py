"""Play between a drive and what it moves."""

from collections.abc import Mapping

import mujoco

from boom_mj.effects.effect import Parameter
from boom_mj.effects.general_effect import SpecEffect, Typical
from boom_mj.effects.surgery import add_series_joint


class Backlash(SpecEffect):
    """Play between a drive and what it moves: a free hinge (or slide) in series, within half a gap either way."""

    id = "backlash"
    where = "joint"
    needs = frozenset({"actuated"})
    sizes = (0.3, 1.0, 3.0)
    confused_with = ("coulomb_friction", "series_compliance")
    told_by = "reversals under small load"

    @classmethod
    def sized(cls, typical: Typical) -> Mapping[str, Parameter]:
        return {"half_gap": Parameter(typical.unit, 0.0, 0.0, 0.5 * typical.span, 0.005 * typical.span)}

    def edit(self, spec: mujoco.MjSpec) -> None:
        if self.values["half_gap"]:
            add_series_joint(spec, self.name, "play", self.values["half_gap"])
