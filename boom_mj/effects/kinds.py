"""Kinds of effects, by what they act on: see `base`."""

from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from boom_mj.effects.base import Array, Effect
from boom_mj.recording import Signal

if TYPE_CHECKING:
    import mujoco

    from boom_mj.machine import Machine

INVERSIONS = 8  # of an angle sensor's error, a hundredth of it or less from one to the next


class MachineEffect(Effect):
    """An effect on numbers of a boom's machine file, before a model is made of it."""

    @abstractmethod
    def change(self, machine: "Machine") -> "Machine":
        """The machine with the effect; neutral values give the same one."""


class ModelEffect(Effect):
    """An effect that MuJoCo simulates by itself."""

    @abstractmethod
    def edit(self, spec: "mujoco.MjSpec", machine: Any) -> None:
        """Change the specification in place; neutral values change no byte.

        Args:
            machine: the boom's `Machine`; None of any other MJCF file.
        """


@dataclass(frozen=True)
class Motion:
    """How a machine moves, as effects that push see it.

    Attributes:
        time: (n,), s, from the start of the recording.
        position, speed: of joints by name, (n,).
        load: what the actuators of joints exert, by name, (n,).
        temperature: of joints by name, (n,), degC, where it is logged.
        machine: the boom's, None of any other MJCF file.
    """

    time: Array
    position: Mapping[str, Array] = field(default_factory=dict)
    speed: Mapping[str, Array] = field(default_factory=dict)
    load: Mapping[str, Array] = field(default_factory=dict)
    temperature: Mapping[str, Array] = field(default_factory=dict)
    machine: "Machine | None" = None

    @property
    def boom(self) -> "Machine":
        """The machine of a boom's effect."""
        assert self.machine is not None
        return self.machine

    @property
    def joints(self) -> Array:
        """Positions, (n, k)."""
        return np.stack(list(self.position.values()), axis=1)


class ForceEffect(Effect):
    """An effect that pushes.

    Attributes:
        sees: the motion of an MJCF machine's free joint that it depends on: "measured", "simulated", or "nominal", that
            of a simulation without effects, to first order the same and cheaper.
        remembers: whether a "simulated" one depends on more than the last two moments and what the filters of
            `boom_mj.effects.laws` keep, which takes longer.
    """

    sees: ClassVar[str] = "measured"
    remembers: ClassVar[bool] = True

    @abstractmethod
    def force(self, motion: Motion) -> Mapping[str, Array]:
        """By name of a site: (n, 3), world frame, N; by name of a joint: (n,), N or N m."""


class ResistEffect(ForceEffect):
    """A force that opposes a joint's motion, by its measured speed."""

    at = ("joint",)
    needs = frozenset({"mjcf", "measured"})

    def force(self, motion: Motion) -> Mapping[str, Array]:
        joint = str(self.site.location["joint"])
        return {joint: -self.resist(motion.speed[joint], motion.load[joint])}

    @abstractmethod
    def resist(self, speed: Array, load: Array) -> Array:
        """Resisting force, positive against positive speed, (n,); load is what the actuator exerts without it."""


class InputEffect(Effect):
    """An effect between an input's true value u and what is logged of it or commanded for it."""

    @abstractmethod
    def apply(self, time: Array, true: Array) -> Array:
        """What comes out: read by an angle sensor, logged by a channel, done by an actuator, (n,)."""

    @abstractmethod
    def invert(self, time: Array, read: Array) -> Array:
        """What went in, (n,)."""


class AngleEffect(InputEffect):
    """An error of a boom's joint angle sensor, which reads u + error(u); errors of one joint add up."""

    at = ("joint",)
    needs = frozenset({"boom"})

    @abstractmethod
    def error(self, angle: Array) -> Array:
        """Reading less true angle, (n,), rad, at true angles (n,); small against the angles it varies over."""

    def apply(self, time: Array, true: Array) -> Array:
        return true + self.error(true)

    def invert(self, time: Array, read: Array) -> Array:
        true = read
        for _ in range(INVERSIONS):
            true = read - self.error(true)
        return true


class ActuatorEffect(InputEffect):
    """What an actuator of any MJCF machine makes of its command."""

    at = ("actuator",)
    needs = frozenset({"mjcf"})


class OutputEffect(Effect):
    """An effect of compared sensors alone."""

    @abstractmethod
    def observe(self, signals: Mapping[str, Signal], machine: Any) -> Mapping[str, Signal]:
        """The signals that it changes, as the affected sensors give them; all come densely sampled, without noise.

        Args:
            machine: the boom's `Machine`; None of any other MJCF file.
        """


class ChannelEffect(InputEffect, OutputEffect):
    """What a channel of any MJCF machine's log makes of the truth: of one that is compared, or of one that drives."""

    at = ("channel",)
    needs = frozenset({"mjcf"})

    def observe(self, signals: Mapping[str, Signal], machine: Any) -> Mapping[str, Signal]:
        name = str(self.site.location["channel"])
        signal = signals[name]
        return {name: replace(signal, values=self.apply(signal.time, signal.values[:, 0])[:, None])}


def is_output(effect: Effect) -> bool:
    """Whether an effect alters simulated signals only, so that it needs no simulation of its own."""
    return isinstance(effect, OutputEffect) and "driving" not in effect.site.tags
