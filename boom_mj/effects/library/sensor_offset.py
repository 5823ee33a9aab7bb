"""Zero offset of a channel."""

from collections.abc import Mapping

from boom_mj.effects import Array, ChannelEffect, Parameter, Site


class SensorOffset(ChannelEffect):
    """Zero offset of a channel."""

    id = "sensor_offset"
    needs = frozenset({"mjcf", "motion"})
    confused_with = ("actuator_bias", "gravity_direction", "quantisation")
    separating_experiment = "poses all around"

    @classmethod
    def parameters(cls, site: Site) -> Mapping[str, Parameter]:
        return {"offset": Parameter(site.unit, 0.0, -5 * site.value, 5 * site.value, 0.05 * site.value)}

    def apply(self, time: Array, true: Array) -> Array:
        return true + self.values["offset"]

    def invert(self, time: Array, read: Array) -> Array:
        return read - self.values["offset"]
