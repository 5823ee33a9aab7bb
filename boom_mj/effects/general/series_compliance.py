"""A spring between a drive, where the angle is measured, and what it moves."""

from collections.abc import Mapping

import mujoco

from boom_mj.effects.effect import Parameter
from boom_mj.effects.general_effect import SpecEffect, Typical
from boom_mj.effects.surgery import add_series_joint


class SeriesCompliance(SpecEffect):
    """A spring between a drive, where the angle is measured, and what it moves: belts, harmonic drives, couplings."""

    id = "series_compliance"
    where = "joint"
    needs = frozenset({"actuated"})
    confused_with = ("backlash", "armature")
    told_by = "fast accelerations"

    @classmethod
    def sized(cls, typical: Typical) -> Mapping[str, Parameter]:
        unit, soft = f"{typical.force_unit}/{typical.unit}", typical.value / typical.span
        return {"stiffness": Parameter(unit, float("inf"), soft, float("inf"), 30 * soft, inverse=True)}

    def edit(self, spec: mujoco.MjSpec) -> None:
        if self.values["stiffness"] < float("inf"):
            add_series_joint(spec, self.name, "give", stiffness=self.values["stiffness"])
