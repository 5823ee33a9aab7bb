"""Play between a drive and what it moves."""

from collections.abc import Mapping
from typing import Any

import mujoco

from boom_mj.effects import ModelEffect, Parameter, Site
from boom_mj.effects.spec_edits import add_series_joint


class Backlash(ModelEffect):
    """Play between a drive and what it moves: a free hinge (or slide) in series, within half a gap either way."""

    id = "backlash"
    at = ("joint",)
    needs = frozenset({"mjcf", "actuated"})
    sizes = (0.3, 1.0, 3.0)
    confused_with = ("coulomb_friction", "series_compliance", "dead_zone", "friction_behind_play")
    separating_experiment = "reversals under small load"

    @classmethod
    def parameters(cls, site: Site) -> Mapping[str, Parameter]:
        return {"half_gap": Parameter(site.unit, 0.0, 0.0, 0.5 * site.span, 0.005 * site.span)}

    def edit(self, spec: mujoco.MjSpec, machine: Any) -> None:
        if self.values["half_gap"]:
            add_series_joint(spec, str(self.location["joint"]), "play", self.values["half_gap"])
