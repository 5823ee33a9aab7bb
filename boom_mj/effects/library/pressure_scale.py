"""A pressure sensor with a wrong gain."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from boom_mj.effects.effect import Parameter, SignalEffect
from boom_mj.machine import Machine
from boom_mj.recording import Signal


class PressureScale(SignalEffect):
    """The force of a cylinder reads too large by a factor."""

    id = "pressure_scale"
    places = {"cylinder": (2, 3)}
    parameters = {"factor": Parameter("1", 1.0, 0.2, 5.0, 0.03)}
    confused_with = ("link_mass", "joint_friction")
    told_by = "sweep"

    def alter(self, signals: Mapping[str, Signal], machine: Machine) -> Mapping[str, Signal]:
        if self.values["factor"] == 1:
            return {}
        force, factor = signals["cylinder/force"], np.ones(2)
        factor[int(self.location["cylinder"]) - 2] = self.values["factor"]
        return {"cylinder/force": replace(force, values=force.values * factor)}
