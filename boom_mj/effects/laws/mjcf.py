"""Laws of any MJCF machine."""

from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from boom_mj.effects.base import Array
from boom_mj.effects.kinds import INVERSIONS, ActuatorEffect, ForceEffect, Motion, OutputEffect
from boom_mj.effects.laws.law import Law
from boom_mj.recording import Signal


class JointLaw(Law, ForceEffect):
    """What resists the motion of a joint of any MJCF machine; `load` is what its actuator exerts without it.

    Of a joint that is free it sees the simulated motion: with the measured one a law could be the joint's equation of
    motion, which any machine fulfils. Where its `variables` hold TEMPERATURE, it is where that is logged.
    """

    sees = "simulated"
    at = ("joint",)
    needs = frozenset({"mjcf", "measured"})
    variables = {"position": "", "speed": "", "load": "", "time": "s"}

    def force(self, motion: Motion) -> Mapping[str, Array]:
        joint = str(self.location["joint"])
        variables = {"position": motion.position[joint], "speed": motion.speed[joint], "load": motion.load[joint]}
        if "temperature" in self.variables:
            variables["temperature"] = motion.temperature[joint]
        return {joint: -self.law(**variables, time=motion.time, **self.values)}

    @abstractmethod
    def law(self, **variables: Any) -> Array:
        """Resisting force, (..., n), N or N m, positive against positive speed; `time` is (n,), the others (..., n)."""


class ActuatorLaw(Law, ActuatorEffect):
    """What an actuator of any MJCF machine makes of its command besides the command itself."""

    variables = {"command": "", "time": "s"}

    def apply(self, time: Array, true: Array) -> Array:
        return true if self.silent else true + self.law(command=true, time=time, **self.values)

    def invert(self, time: Array, read: Array) -> Array:
        true = read
        for _ in range(0 if self.silent else INVERSIONS):
            true = read - self.law(command=true, time=time, **self.values)
        return true

    @abstractmethod
    def law(self, **variables: Any) -> Array:
        """What is done less what is commanded, (n,)."""


class ChannelLaw(Law, OutputEffect):
    """What a compared channel of any MJCF machine reads besides; see `JointLaw` of a temperature."""

    at = ("channel",)
    needs = frozenset({"mjcf", "compared"})
    variables = {"reading": "", "time": "s"}

    def observe(self, signals: Mapping[str, Signal], machine: Any) -> Mapping[str, Signal]:
        if self.silent:
            return {}
        name = str(self.location["channel"])
        known = {key: value for key, value in channel_variables(signals, name).items() if key in self.variables}
        values = signals[name].values + self.law(**known, **self.values)[:, None]
        return {name: replace(signals[name], values=values)}

    @abstractmethod
    def law(self, **variables: Any) -> Array:
        """What it reads too much, (n,), in its unit."""


def channel_variables(signals: Mapping[str, Signal], name: str) -> dict[str, Array]:
    """Of a channel; see `ChannelLaw`."""
    found = {"reading": signals[name].values[:, 0], "time": signals[name].time}
    warm = signals.get(f"temperature/{name}")
    return found if warm is None else {**found, "temperature": warm.values[:, 0]}
