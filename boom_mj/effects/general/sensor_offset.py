"""Zero offset of a channel."""

from collections.abc import Mapping

from boom_mj.effects.effect import Array, Parameter
from boom_mj.effects.general_effect import ChannelEffect, Typical


class SensorOffset(ChannelEffect):
    """Zero offset of a channel."""

    id = "sensor_offset"
    needs = frozenset({"motion"})
    confused_with = ("actuator_bias", "gravity_direction")
    told_by = "poses all around"

    @classmethod
    def sized(cls, typical: Typical) -> Mapping[str, Parameter]:
        return {"offset": Parameter(typical.unit, 0.0, -5 * typical.value, 5 * typical.value, 0.05 * typical.value)}

    def read(self, time: Array, true: Array) -> Array:
        return true + self.values["offset"]

    def true(self, time: Array, logged: Array) -> Array:
        return logged - self.values["offset"]
