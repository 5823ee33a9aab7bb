"""First-order low-pass filter of a logged channel."""

from collections.abc import Mapping

from boom_mj.effects import Array, ChannelEffect, Parameter, Site
from boom_mj.effects.filters import lagged, led


class LowPass(ChannelEffect):
    """First-order low-pass filter of a logged channel."""

    id = "low_pass"
    needs = frozenset({"mjcf", "motion"})
    sizes = (1.0, 4.0)
    confused_with = ("sensor_delay", "actuator_lag", "second_order_low_pass")
    separating_experiment = "fast motion"

    @classmethod
    def parameters(cls, site: Site) -> Mapping[str, Parameter]:
        return {"time_constant": Parameter("s", 0.0, 0.0, 500 * site.step, 2 * site.step)}

    def apply(self, time: Array, true: Array) -> Array:
        return lagged(time, true, self.values["time_constant"])

    def invert(self, time: Array, read: Array) -> Array:
        return led(time, read, self.values["time_constant"])
