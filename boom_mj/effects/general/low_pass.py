"""First-order low-pass filter of a logged channel."""

from collections.abc import Mapping

from boom_mj.effects.effect import Array, Parameter
from boom_mj.effects.general_effect import ChannelEffect, Typical, lagged, led


class LowPass(ChannelEffect):
    """First-order low-pass filter of a logged channel."""

    id = "low_pass"
    sizes = (1.0, 4.0)
    needs = frozenset({"motion"})
    confused_with = ("sensor_delay", "actuator_lag")
    told_by = "fast motion"

    @classmethod
    def sized(cls, typical: Typical) -> Mapping[str, Parameter]:
        return {"time_constant": Parameter("s", 0.0, 0.0, 500 * typical.step, 2 * typical.step)}

    def read(self, time: Array, true: Array) -> Array:
        return lagged(time, true, self.values["time_constant"])

    def true(self, time: Array, logged: Array) -> Array:
        return led(time, logged, self.values["time_constant"])
