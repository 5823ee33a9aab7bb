"""Channel whose values come late."""

from collections.abc import Mapping

from boom_mj.effects import Array, ChannelEffect, Parameter, Site
from boom_mj.effects.filters import later


class SensorDelay(ChannelEffect):
    """Channel whose values come late."""

    id = "sensor_delay"
    needs = frozenset({"mjcf", "motion"})
    sizes = (1.0, 4.0, -1.0)
    confused_with = ("low_pass", "actuator_delay", "second_order_low_pass")
    separating_experiment = "fast motion"

    @classmethod
    def parameters(cls, site: Site) -> Mapping[str, Parameter]:
        return {"delay": Parameter("s", 0.0, -200 * site.step, 200 * site.step, 2 * site.step)}

    def apply(self, time: Array, true: Array) -> Array:
        return later(time, true, self.values["delay"])

    def invert(self, time: Array, read: Array) -> Array:
        return later(time, read, -self.values["delay"])
