"""A base that does not stand upright."""

from collections.abc import Mapping

import mujoco

from boom_mj.effects.effect import Parameter
from boom_mj.effects.general_effect import SpecEffect, Typical
from boom_mj.effects.surgery import turn_gravity


class GravityDirection(SpecEffect):
    """A base that does not stand upright: gravity turned about x (roll) and y (pitch) of the model."""

    id = "gravity_direction"
    where = ""
    needs = frozenset({"heavy"})
    confused_with = ("actuator_bias", "sensor_offset")
    told_by = "poses all around"

    @classmethod
    def sized(cls, typical: Typical) -> Mapping[str, Parameter]:
        tilt = Parameter("rad", 0.0, -0.1, 0.1, 0.02)
        return {"roll": tilt, "pitch": tilt}

    def edit(self, spec: mujoco.MjSpec) -> None:
        turn_gravity(spec, self.values["roll"], self.values["pitch"])
