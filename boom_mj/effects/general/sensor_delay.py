"""Channel whose values come late."""

from collections.abc import Mapping

from boom_mj.effects.effect import Array, Parameter
from boom_mj.effects.general_effect import ChannelEffect, Typical, later


class SensorDelay(ChannelEffect):
    """Channel whose values come late."""

    id = "sensor_delay"
    sizes = (1.0, 4.0, -1.0)
    needs = frozenset({"motion"})
    confused_with = ("low_pass", "actuator_delay")
    told_by = "fast motion"

    @classmethod
    def sized(cls, typical: Typical) -> Mapping[str, Parameter]:
        return {"delay": Parameter("s", 0.0, -200 * typical.step, 200 * typical.step, 2 * typical.step)}

    def read(self, time: Array, true: Array) -> Array:
        return later(time, true, self.values["delay"])

    def true(self, time: Array, logged: Array) -> Array:
        return later(time, logged, -self.values["delay"])
