"""Scale of a channel."""

from collections.abc import Mapping

from boom_mj.effects.effect import Array, Parameter
from boom_mj.effects.general_effect import ChannelEffect, Typical


class SensorScale(ChannelEffect):
    """Scale of a channel: gain of an amplifier, of a strain gauge, of a gear between joint and sensor."""

    id = "sensor_scale"
    needs = frozenset({"motion"})
    confused_with = ("joint_stiffness", "body_mass")
    told_by = "a known angle or load"

    @classmethod
    def sized(cls, typical: Typical) -> Mapping[str, Parameter]:
        return {"factor": Parameter("", 1.0, 0.5, 2.0, 0.05)}

    def read(self, time: Array, true: Array) -> Array:
        return self.values["factor"] * true

    def true(self, time: Array, logged: Array) -> Array:
        return logged / self.values["factor"]
