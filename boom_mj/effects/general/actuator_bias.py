"""An actuator that pushes without being told to."""

from collections.abc import Mapping

from boom_mj.effects.effect import Array, Parameter
from boom_mj.effects.general_effect import CommandEffect, Typical


class ActuatorBias(CommandEffect):
    """An actuator that pushes without being told to: offset of its amplifier, or a constant force on its joint."""

    id = "actuator_bias"
    confused_with = ("asymmetric_friction", "gravity_direction")
    told_by = "motions both ways"

    @classmethod
    def sized(cls, typical: Typical) -> Mapping[str, Parameter]:
        return {"offset": Parameter(typical.unit, 0.0, -5 * typical.value, 5 * typical.value, 0.05 * typical.value)}

    def act(self, time: Array, command: Array) -> Array:
        return command + self.values["offset"]

    def command(self, time: Array, action: Array) -> Array:
        return action - self.values["offset"]
