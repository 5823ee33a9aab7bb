"""Torque constant of a motor, or gain of its amplifier, by a factor."""

from collections.abc import Mapping

from boom_mj.effects.effect import Array, Parameter
from boom_mj.effects.general_effect import CommandEffect, Typical


class ActuatorGain(CommandEffect):
    """Torque constant of a motor, or gain of its amplifier, by a factor."""

    id = "actuator_gain"
    confused_with = ("body_mass", "load_friction")
    told_by = "a known static load"

    @classmethod
    def sized(cls, typical: Typical) -> Mapping[str, Parameter]:
        return {"factor": Parameter("", 1.0, 0.5, 2.0, 0.1)}

    def act(self, time: Array, command: Array) -> Array:
        return self.values["factor"] * command

    def command(self, time: Array, action: Array) -> Array:
        return action / self.values["factor"]
