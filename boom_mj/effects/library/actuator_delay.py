"""Dead time between the command of an actuator and what it does."""

from collections.abc import Mapping

from boom_mj.effects import ActuatorEffect, Array, Parameter, Site
from boom_mj.effects.filters import later


class ActuatorDelay(ActuatorEffect):
    """Dead time between the command of an actuator and what it does."""

    id = "actuator_delay"
    sizes = (1.0, 4.0)
    confused_with = ("actuator_lag", "sensor_delay")
    separating_experiment = "steps"

    @classmethod
    def parameters(cls, site: Site) -> Mapping[str, Parameter]:
        return {"delay": Parameter("s", 0.0, 0.0, 200 * site.step, 2 * site.step)}

    def apply(self, time: Array, true: Array) -> Array:
        return later(time, true, self.values["delay"])

    def invert(self, time: Array, read: Array) -> Array:
        return later(time, read, -self.values["delay"])
