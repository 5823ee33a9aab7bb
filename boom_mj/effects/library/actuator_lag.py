"""First-order lag of an actuator."""

from collections.abc import Mapping

from boom_mj.effects import ActuatorEffect, Array, Parameter, Site
from boom_mj.effects.filters import lagged, led


class ActuatorLag(ActuatorEffect):
    """First-order lag of an actuator: winding inductance, valves, a slow inner loop."""

    id = "actuator_lag"
    sizes = (1.0, 4.0)
    confused_with = ("actuator_delay", "low_pass")
    separating_experiment = "steps"

    @classmethod
    def parameters(cls, site: Site) -> Mapping[str, Parameter]:
        return {"time_constant": Parameter("s", 0.0, 0.0, 200 * site.step, 2 * site.step)}

    def apply(self, time: Array, true: Array) -> Array:
        return lagged(time, true, self.values["time_constant"])

    def invert(self, time: Array, read: Array) -> Array:
        return led(time, read, self.values["time_constant"])
