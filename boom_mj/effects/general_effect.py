"""Effects of machines that are not booms: what any MJCF file may lack, at its joints, bodies, actuators and channels.

One effect is one file in `general/`; being there is being registered. Places and typical sizes come from the machine:
`at` makes the class of an effect at one place of one model. An effect acts in one of four ways:

    SpecEffect       edits the MuJoCo specification
    ResistEffect     a force on a joint whose motion is measured, -f(speed, load) sign(speed)
    CommandEffect    stands between what is commanded of an actuator (V, A, N) and what it does
    ChannelEffect    stands between what is true and what a channel of the log says

The last two come with their inverses: where measured motion drives a joint, the model says what its actuator must have
done, hence what was commanded; and a channel that drives says what was true.
"""

from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import ClassVar

import mujoco
import numpy as np

from boom_mj.effects.effect import Effect, Parameter, registered

Array = np.ndarray


@dataclass(frozen=True)
class Typical:
    """Sizes at a place of a machine, from its nominal model and the logs to learn from.

    Attributes:
        unit: of the channel, or of the joint's coordinate (rad or m).
        value: root mean square of what is commanded or logged there, or of the joint's force.
        span: of the joint's coordinate.
        speed: root mean square of the joint's speed.
        inertia, damping, stiffness, armature: of the joint in the nominal model.
        mass: of the body.
        step: between samples, s.
    """

    unit: str = ""
    value: float = 1.0
    span: float = 1.0
    speed: float = 1.0
    inertia: float = 1.0
    damping: float = 0.0
    stiffness: float = 0.0
    armature: float = 0.0
    mass: float = 1.0
    step: float = 1e-3

    @property
    def force_unit(self) -> str:
        return "N" if self.unit == "m" else "N m"


class GeneralEffect(Effect):
    """Common to all four kinds.

    Attributes:
        where: key of its place: "joint", "body", "actuator" or "channel"; "" for the whole machine.
        needs: words that the place must be tagged with, such as "driven", "compared", "turns".
    """

    where: ClassVar[str]
    needs: ClassVar[frozenset[str]] = frozenset()
    parameters: ClassVar[Mapping[str, Parameter]] = {}

    @classmethod
    @abstractmethod
    def sized(cls, typical: Typical) -> Mapping[str, Parameter]:
        """Parameters with bounds and typical sizes at a place."""

    @classmethod
    def at(cls, name: str, typical: Typical) -> "type[GeneralEffect]":
        """The effect at one place, as a class that the diagnosis can make instances of."""
        places = {cls.where: (name,)} if cls.where else {}
        return type(cls.__name__, (cls,), {"places": places, "parameters": cls.sized(typical), "__doc__": cls.__doc__})

    @property
    def name(self) -> str:
        """Of the joint, body, actuator or channel."""
        return str(self.location[self.where])


class SpecEffect(GeneralEffect):
    """An effect that MuJoCo simulates by itself."""

    @abstractmethod
    def edit(self, spec: mujoco.MjSpec) -> None:
        """Change the specification in place; neutral values change nothing."""


class ResistEffect(GeneralEffect):
    """A force that opposes a joint's motion, by its measured speed."""

    where = "joint"
    needs = frozenset({"measured"})

    @abstractmethod
    def resist(self, speed: Array, load: Array) -> Array:
        """Resisting force, positive against positive speed, (n,); load is what the actuator exerts without it."""


class CommandEffect(GeneralEffect):
    """What an actuator makes of its command."""

    where = "actuator"

    @abstractmethod
    def act(self, time: Array, command: Array) -> Array:
        """What the actuator does, in units of the command, (n,)."""

    @abstractmethod
    def command(self, time: Array, action: Array) -> Array:
        """What must have been commanded for it, (n,)."""


class ChannelEffect(GeneralEffect):
    """What a channel makes of the truth."""

    where = "channel"

    @abstractmethod
    def read(self, time: Array, true: Array) -> Array:
        """What is logged, (n,)."""

    @abstractmethod
    def true(self, time: Array, logged: Array) -> Array:
        """What was true, (n,)."""


def later(time: Array, values: Array, delay: float) -> Array:
    """Values that come later by some seconds (earlier, for a negative delay), (n,)."""
    return np.interp(time - delay, time, values)


def lagged(time: Array, values: Array, constant: float) -> Array:
    """Through a first-order low-pass with some time constant, s, from rest, (n,); exact for uniform times."""
    if constant <= 0 or len(time) < 2:
        return values
    from scipy.signal import lfilter

    keep = np.exp(-(time[1] - time[0]) / constant)
    return lfilter([1 - keep], [1, -keep], values, zi=[keep * values[0]])[0]


def led(time: Array, values: Array, constant: float) -> Array:
    """What a first-order low-pass has made these values of, (n,)."""
    return values if constant <= 0 else values + constant * np.gradient(values, time)


@cache
def general_library() -> Mapping[str, type[GeneralEffect]]:
    """Every effect of `general/`, by id."""
    return registered("boom_mj.effects.general", GeneralEffect)  # type: ignore[type-abstract]
