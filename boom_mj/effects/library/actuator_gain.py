"""Torque constant of a motor, or gain of its amplifier, by a factor."""

from collections.abc import Mapping

from boom_mj.effects import ActuatorEffect, Array, Parameter, Site


class ActuatorGain(ActuatorEffect):
    """Torque constant of a motor, or gain of its amplifier, by a factor."""

    id = "actuator_gain"
    confused_with = ("body_mass", "load_friction", "armature", "sprung_inertia")
    separating_experiment = "a known static load"

    @classmethod
    def parameters(cls, site: Site) -> Mapping[str, Parameter]:
        return {"factor": Parameter("1", 1.0, 0.5, 2.0, 0.1, likely=(0.8, 1.25))}  # magnets and gears differ by 20 %

    def apply(self, time: Array, true: Array) -> Array:
        return self.values["factor"] * true

    def invert(self, time: Array, read: Array) -> Array:
        return read / self.values["factor"]
