"""A candidate: effects at their places whose free knobs are coordinates of one vector."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from boom_mj.effects import Effect, Parameter
from boom_mj.effects.effect import Location
from boom_mj.systems.system import System

Array = np.ndarray
STEP = 0.02  # of a coordinate, for secants


@dataclass(frozen=True)
class Candidate:
    """One or more effects to be fitted together, from a start.

    Attributes:
        effects: at their starting values.
    """

    effects: tuple[Effect, ...]

    @property
    def knobs(self) -> tuple[tuple[int, str, Parameter], ...]:
        """(index of the effect, name of the parameter, parameter) of every coordinate."""
        return tuple(
            (k, name, effect.parameters[name])
            for k, effect in enumerate(self.effects)
            for name in effect.knobs(effect.location)
        )

    @property
    def start(self) -> Array:
        """Coordinates of the starting values, (p,)."""
        return np.array([knob.coordinate(self.effects[k].values[name]) for k, name, knob in self.knobs])

    def at(self, coordinates: Array) -> tuple[Effect, ...]:
        """The effects at given coordinates, (p,)."""
        values = [dict(effect.values) for effect in self.effects]
        for (k, name, knob), coordinate in zip(self.knobs, coordinates):
            values[k][name] = knob.value(float(coordinate))
        return tuple(type(e)(e.location, **v) for e, v in zip(self.effects, values))

    def bounds(self) -> tuple[Array, Array]:
        """Smallest and largest coordinates, (p,) each."""
        ends = [sorted((knob.coordinate(knob.low), knob.coordinate(knob.high))) for *_, knob in self.knobs]
        return np.array([low for low, _ in ends]), np.array([high for _, high in ends])

    def steps(self, coordinates: Array) -> tuple[Array, list[tuple[Effect, ...]]]:
        """A small step of every coordinate that its bounds allow, (p,), and the effects after each of them alone."""
        steps = np.where(coordinates + STEP <= self.bounds()[1], STEP, -STEP)
        return steps, [self.at(coordinates + step * row) for step, row in zip(steps, np.eye(len(steps)))]

    def simpler(self) -> Iterator["Candidate"]:
        """Without one of several effects, or with one where it has fewer knobs, such as roll for roll and pitch."""
        for one in self.effects:
            others, kind = tuple(e for e in self.effects if e is not one), type(one)
            if others:
                yield Candidate(others)
            for place in kind.locations():
                knobs = set(kind.knobs(place))
                if knobs < set(kind.knobs(one.location)):
                    yield Candidate((*others, kind(place, **{name: one.values[name] for name in knobs})))

    @property
    def places(self) -> tuple[tuple[str, tuple], ...]:
        """What and where, without sizes: equal for equal causes."""
        return tuple(sorted(effect.cause for effect in self.effects))

    @property
    def label(self) -> str:
        return " + ".join(" ".join([e.id, *(f"{k} {v}" for k, v in e.location.items())]) for e in self.effects)


def causes(kind: type[Effect], place: Location) -> set[tuple]:
    """What an effect is at a place, its special cases too: of two that share one, the data cannot tell the sizes.

    Where places differ in their knobs, such as roll from roll and pitch, each knob is a cause.
    """
    knobs = kind.knobs(place)
    divided = any(kind.knobs(other) != knobs for other in kind.locations())
    parts = knobs if divided else [tuple(place.items())]
    return {(name, part) for name in (kind.id, *kind.special_cases) for part in parts}


def apart(kind: type[Effect], place: Location, effects: Sequence[Effect]) -> bool:
    """Whether an effect at a place shares no cause with others, so that it can stand beside them."""
    return not any(causes(kind, place) & causes(type(other), other.location) for other in effects)


def everywhere(subject: System, without: Sequence[str] = ()) -> list[tuple[type[Effect], dict]]:
    """Every effect of a subject's library at every place, but for the ids left out."""
    return [(kind, place) for kind, place in subject.library() if kind.id not in without]
