"""An actuator that pushes without being told to."""

from collections.abc import Mapping

from boom_mj.effects import ActuatorEffect, Array, Parameter, Site


class ActuatorBias(ActuatorEffect):
    """An actuator that pushes without being told to: offset of its amplifier, or a constant force on its joint."""

    id = "actuator_bias"
    confused_with = ("asymmetric_friction", "gravity_direction", "sensor_offset", "asymmetric_dead_zone")
    separating_experiment = "motions both ways"

    @classmethod
    def parameters(cls, site: Site) -> Mapping[str, Parameter]:
        size, likely = (
            site.value,
            (-0.5 * site.value, 0.5 * site.value),
        )  # what is half of all that it does is no offset
        return {"offset": Parameter(site.unit, 0.0, -5 * size, 5 * size, 0.05 * size, likely=likely)}

    def apply(self, time: Array, true: Array) -> Array:
        return true + self.values["offset"]

    def invert(self, time: Array, read: Array) -> Array:
        return read - self.values["offset"]
