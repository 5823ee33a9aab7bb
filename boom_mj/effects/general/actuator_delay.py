"""Dead time between the command of an actuator and what it does."""

from collections.abc import Mapping

from boom_mj.effects.effect import Array, Parameter
from boom_mj.effects.general_effect import CommandEffect, Typical, later


class ActuatorDelay(CommandEffect):
    """Dead time between the command of an actuator and what it does."""

    id = "actuator_delay"
    sizes = (1.0, 4.0)
    confused_with = ("actuator_lag", "sensor_delay")
    told_by = "steps"

    @classmethod
    def sized(cls, typical: Typical) -> Mapping[str, Parameter]:
        return {"delay": Parameter("s", 0.0, 0.0, 200 * typical.step, 2 * typical.step)}

    def act(self, time: Array, command: Array) -> Array:
        return later(time, command, self.values["delay"])

    def command(self, time: Array, action: Array) -> Array:
        return later(time, action, -self.values["delay"])
