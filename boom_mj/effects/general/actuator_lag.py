"""First-order lag of an actuator."""

from collections.abc import Mapping

from boom_mj.effects.effect import Array, Parameter
from boom_mj.effects.general_effect import CommandEffect, Typical, lagged, led


class ActuatorLag(CommandEffect):
    """First-order lag of an actuator: winding inductance, valves, a slow inner loop."""

    id = "actuator_lag"
    sizes = (1.0, 4.0)
    confused_with = ("actuator_delay", "low_pass")
    told_by = "steps"

    @classmethod
    def sized(cls, typical: Typical) -> Mapping[str, Parameter]:
        return {"time_constant": Parameter("s", 0.0, 0.0, 200 * typical.step, 2 * typical.step)}

    def act(self, time: Array, command: Array) -> Array:
        return lagged(time, command, self.values["time_constant"])

    def command(self, time: Array, action: Array) -> Array:
        return led(time, action, self.values["time_constant"])
