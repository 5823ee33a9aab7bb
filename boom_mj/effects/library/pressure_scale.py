"""A pressure sensor with a wrong gain."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from boom_mj.effects import OutputEffect, Parameter
from boom_mj.machine import Machine
from boom_mj.recording import Signal


class PressureScale(OutputEffect):
    """The force of a cylinder reads too large by a factor."""

    id = "pressure_scale"
    at = ("cylinder",)
    needs = frozenset({"boom"})
    table = {"factor": Parameter("1", 1.0, 0.2, 5.0, 0.03)}
    confused_with = ("link_mass", "joint_friction", "viscous_friction")
    separating_experiment = "sweep"

    def observe(self, signals: Mapping[str, Signal], machine: Machine) -> Mapping[str, Signal]:
        if self.values["factor"] == 1:
            return {}
        force, factor = signals["cylinder/force"], np.ones(2)
        factor[int(self.location["cylinder"]) - 2] = self.values["factor"]
        return {"cylinder/force": replace(force, values=force.values * factor)}
