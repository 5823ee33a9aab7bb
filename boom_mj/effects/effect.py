"""Effects: what a machine has and the nominal model lacks.

An effect is a term with parameters p whose neutral value p0 makes it vanish to the last byte of the MJCF and of the
recording, so that "off" needs no branch and hypotheses add up. It acts in one of four ways, and what it acts on is its
type: a `ModelEffect` edits the MuJoCo specification, a `LoadEffect` pushes on sites of the model, a `SignalEffect`
alters what the sensors say, an `AngleEffect` stands between a joint and the sensor whose angles drive the model. One
effect is one file in `library/`; being there is being registered.

The diagnosis sees an effect as a point c in the space of its knobs, one coordinate per parameter, with c = 0 neutral
and |c| = 1 a size worth finding:

    c = (p - p0) / s     "linear",            c = s / p     "inverse": a stiffness, neutral where it is infinite.
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from itertools import product
from pkgutil import iter_modules
from typing import Any, ClassVar, TypeVar

import mujoco
import numpy as np

from boom_mj.errors import EffectError
from boom_mj.machine import Machine
from boom_mj.recording import Signal

Array = np.ndarray
Location = Mapping[str, int | str]
Values = Mapping[str, float]
KNOT = 0.1  # s, between the pulses of which a course in time is made
COURSE_TIME = 2.0  # s, correlation time of a course


@dataclass(frozen=True)
class Parameter:
    """A number that an effect takes.

    Attributes:
        unit: SI unit.
        neutral: value at which the effect vanishes.
        low, high: bounds, the neutral value among them.
        typical: distance from neutral that is worth finding; for an inverse one, the value itself.
        inverse: whether its reciprocal is what acts (stiffness of something that nominally does not give).
    """

    unit: str
    neutral: float
    low: float
    high: float
    typical: float
    inverse: bool = False

    @property
    def bounds(self) -> tuple[float, float]:
        """Least and largest value."""
        return self.low, self.high

    def coordinate(self, value: float) -> float:
        """Where a value lies: 0 neutral, 1 typical."""
        return self.typical / value if self.inverse else (value - self.neutral) / self.typical

    def value(self, coordinate: float) -> float:
        """The parameter at a coordinate, kept within its bounds."""
        if self.inverse:
            found = self.typical / coordinate if coordinate > 0 else np.inf
        else:
            found = self.neutral + coordinate * self.typical
        return float(np.clip(found, self.low, self.high))


class Effect(ABC):
    """Common to all kinds: a name, where it can be, parameters, what it is confused with and what tells them apart.

    Attributes:
        places: key -> choices, such as {"link": (2, 3, 4, 5), "axis": ("v", "w", "torsion")}.
        parameters: by name.
        confused_with: ids (or words) of what looks alike.
        special_cases: ids of effects that it becomes at some of its values.
        told_by: experiment of the catalogue that tells.
        sizes: coordinates at which screening looks; several, and both signs, where the effect is not smooth.
        rungs: coordinates between which a fit is begun at the least cost, where it has many minima.
        location, values: of this instance; parameters left out are neutral.
    """

    id: ClassVar[str]
    parameters: ClassVar[Mapping[str, Parameter]]
    places: ClassVar[Mapping[str, Sequence[int | str]]] = {}
    confused_with: ClassVar[tuple[str, ...]] = ()
    special_cases: ClassVar[tuple[str, ...]] = ()
    told_by: ClassVar[str] = ""
    sizes: ClassVar[tuple[float, ...]] = (1.0,)
    rungs: ClassVar[tuple[float, ...]] = ()

    def __init__(self, location: Location | None = None, **values: float) -> None:
        self.location = dict(location or {})
        for key, choices in self.places.items():
            if self.location.get(key) not in choices:
                known, given = ", ".join(map(str, choices)), self.location.get(key)
                raise EffectError(f"effect {self.id} needs {key} = one of {known}; got {given}")
        for name in (*self.location, *values):
            if name not in self.parameters and name not in self.places:
                known = ", ".join((*self.places, *self.parameters))
                raise EffectError(f"effect {self.id} has no parameter {name!r}; it has: {known}")
        for name, value in values.items():
            bound = self.parameters[name]
            if not bound.low <= value <= bound.high:
                raise EffectError(
                    f"effect {self.id}: {name} = {value:g} {bound.unit} is outside [{bound.low:g}, {bound.high:g}]"
                )
        self.values = {name: float(values.get(name, bound.neutral)) for name, bound in self.parameters.items()}

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Effect) and self.key == other.key

    def __hash__(self) -> int:
        return hash(self.key)

    def __repr__(self) -> str:
        pairs = [*self.location.items(), *((k, f"{v:.6g}") for k, v in self.values.items())]
        return f"{self.id}:{','.join(f'{k}={v}' for k, v in pairs)}"

    def __reduce__(self) -> tuple[Any, ...]:
        return _revive, (self.id, self.location, self.values)

    def pulse(self, time: float) -> "Effect | None":
        """Where part of what it does has a course in time that no log tells: it with a pulse of that course instead.

        The pulse is a hat that rises from 0 to 1 within KNOT before the time (s) and falls as fast.
        """
        return None

    def course(self, strength: float) -> dict[str, float]:
        """What its parameters are if a course of this strength (standard deviation in pulses) comes on top."""
        return {}

    @property
    def strongest(self) -> float:
        """Of the courses that its values allow, in pulses."""
        return 0.0

    @property
    def cause(self) -> tuple[Any, ...]:
        """What and where, without sizes: equal for equal causes."""
        return self.id, tuple(sorted(self.location.items()))

    @property
    def key(self) -> tuple[Any, ...]:
        """Id, place and values, by which effects are equal."""
        return *self.cause, tuple(sorted(self.values.items()))

    @classmethod
    def locations(cls) -> list[dict[str, int | str]]:
        """Every place where the effect can be."""
        return [dict(zip(cls.places, choice)) for choice in product(*cls.places.values())]

    @classmethod
    def knobs(cls, location: Location) -> tuple[str, ...]:
        """Parameters that are free at a location."""
        return tuple(cls.parameters)

    @classmethod
    def probes(cls, location: Location, lines: Sequence[float] = ()) -> list[list[dict[str, float]]]:
        """Where screening looks: alternatives, each of one or more values whose effects add up linearly.

        Args:
            lines: frequencies (Hz) that stand out of the residual.
        """
        return [[{name: cls.parameters[name].value(size)} for name in cls.knobs(location)] for size in cls.sizes]

    @classmethod
    def blend(cls, probes: Sequence[Values], weights: Array) -> dict[str, float]:
        """Values whose effect is, to first order, the weighted sum of the probes' effects."""
        coordinates: dict[str, float] = {}
        for probe, weight in zip(probes, weights):
            for name, value in probe.items():
                coordinates[name] = coordinates.get(name, 0.0) + weight * cls.parameters[name].coordinate(value)
        return {name: cls.parameters[name].value(c) for name, c in coordinates.items()}


class ModelEffect(Effect):
    """An effect that MuJoCo simulates."""

    @abstractmethod
    def edit(self, spec: mujoco.MjSpec, machine: Machine) -> None:
        """Change the specification in place; neutral values change nothing."""


class LoadEffect(Effect):
    """An effect that pushes."""

    @abstractmethod
    def push(self, machine: Machine, time: Array, joints: Array) -> Mapping[str, Array]:
        """Forces on sites over time: name of the site -> (n, 3), world frame, N.

        Args:
            time: (n,), s, from the start of the recording.
            joints: q1..q5, (n, 5), rad.
        """


class SignalEffect(Effect):
    """An effect of the sensors alone."""

    @abstractmethod
    def alter(self, signals: Mapping[str, Signal], machine: Machine) -> Mapping[str, Signal]:
        """The signals that it changes, as the affected sensors give them; all come densely sampled, without noise."""


class AngleEffect(Effect):
    """An error of the joint angle sensors, by which a log drives the model."""

    @abstractmethod
    def error(self, angles: Array) -> Array:
        """Reading less true angle, (n, 5), rad, at true angles (n, 5); small against the angles it varies over."""


def _revive(name: str, location: Location, values: Values) -> Effect:
    return effect_library()[name](location, **values)


Kind = TypeVar("Kind", bound=Effect)


def registered(folder: str, base: type[Kind]) -> Mapping[str, type[Kind]]:
    """Every kind of effect that a package's modules define, by id."""
    modules = [import_module(f"{folder}.{m.name}") for m in iter_modules(import_module(folder).__path__)]
    kinds = [
        kind
        for module in modules
        for kind in vars(module).values()
        if isinstance(kind, type) and issubclass(kind, base) and kind.__module__ == module.__name__
    ]
    return {kind.id: kind for kind in sorted(kinds, key=lambda kind: kind.id)}


@cache
def effect_library() -> Mapping[str, type[Effect]]:
    """Every effect of `library/`, by id."""
    return registered("boom_mj.effects.library", Effect)


def make_effect(name: str, entries: Mapping[str, Any]) -> Effect:
    """An effect from its id and its location and parameters in one mapping, as machine files hold them.

    Raises:
        EffectError: unknown effect, place or parameter, or a value that is no number or out of bounds.
    """
    known = effect_library()
    if name not in known:
        raise EffectError(f"no effect {name!r}; the library holds: {', '.join(known)}")
    kind = known[name]
    location = {key: _choice(entries[key], kind.places[key]) for key in kind.places if key in entries}
    values = {}
    for key, value in entries.items():
        if key not in location:
            try:
                values[key] = float(value)
            except (TypeError, ValueError) as error:
                raise EffectError(f"effect {name}: {key} = {value!r} should be a number") from error
    return kind(location, **values)


def _choice(given: Any, choices: Sequence[int | str]) -> Any:
    """The choice that reads as what was given, or what was given."""
    return next((choice for choice in choices if str(choice) == str(given)), given)


def parse_effect(text: str) -> Effect:
    """An effect from `ID:key=value,...`; see `make_effect`."""
    name, _, rest = text.partition(":")
    pairs = [pair.partition("=") for pair in filter(None, rest.split(","))]
    for key, equals, _ in pairs:
        if not equals:
            raise EffectError(f"effect {name}: {key!r} should read key=value")
    return make_effect(name, {key.strip(): value.strip() for key, _, value in pairs})


def effects_of(machine: Machine) -> tuple[Effect, ...]:
    """The effects that a machine file holds."""
    return tuple(make_effect(entry.id, entry.model_extra or {}) for entry in machine.effect)
