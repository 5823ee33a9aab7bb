"""A spring between a drive, where the angle is measured, and what it moves."""

from collections.abc import Mapping
from typing import Any

import mujoco

from boom_mj.effects import ModelEffect, Parameter, Site
from boom_mj.effects.spec_edits import add_series_joint


class SeriesCompliance(ModelEffect):
    """A spring between a drive, where the angle is measured, and what it moves: belts, harmonic drives, couplings."""

    id = "series_compliance"
    at = ("joint",)
    needs = frozenset({"mjcf", "actuated"})
    confused_with = ("backlash", "armature", "friction_behind_play")
    separating_experiment = "fast accelerations"

    @classmethod
    def parameters(cls, site: Site) -> Mapping[str, Parameter]:
        unit, soft = f"{site.force_unit}/{site.unit}", site.value / site.span
        return {"stiffness": Parameter(unit, float("inf"), soft, float("inf"), 30 * soft, inverse=True)}

    def edit(self, spec: mujoco.MjSpec, machine: Any) -> None:
        if self.values["stiffness"] < float("inf"):
            add_series_joint(spec, str(self.location["joint"]), "give", stiffness=self.values["stiffness"])
