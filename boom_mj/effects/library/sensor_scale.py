"""Scale of a channel."""

from collections.abc import Mapping

from boom_mj.effects import Array, ChannelEffect, Parameter, Site


class SensorScale(ChannelEffect):
    """Scale of a channel: gain of an amplifier, of a strain gauge, of a gear between joint and sensor."""

    id = "sensor_scale"
    needs = frozenset({"mjcf", "motion"})
    confused_with = ("joint_stiffness", "body_mass")
    separating_experiment = "a known angle or load"

    @classmethod
    def parameters(cls, site: Site) -> Mapping[str, Parameter]:
        return {"factor": Parameter("1", 1.0, 0.5, 2.0, 0.05, likely=(0.95, 1.05))}  # gauges are good to 5 %

    def apply(self, time: Array, true: Array) -> Array:
        return self.values["factor"] * true

    def invert(self, time: Array, read: Array) -> Array:
        return read / self.values["factor"]
