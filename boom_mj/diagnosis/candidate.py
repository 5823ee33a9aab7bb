"""A candidate: effects at their sites whose free parameters, scaled, are one vector."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from boom_mj.effects import BOOM_SITES, Effect, Parameter, Site, effect_library
from boom_mj.effects.base import Cause
from boom_mj.systems.system import System

Array = np.ndarray
Kind = tuple[type[Effect], Site]
STEP = 0.02  # of a scaled parameter, for secants


@dataclass(frozen=True)
class Candidate:
    """One or more effects to be fitted together, from a start.

    Attributes:
        effects: at their starting values.
    """

    effects: tuple[Effect, ...]

    @cached_property
    def parameters(self) -> tuple[tuple[int, str, Parameter], ...]:
        """(index of the effect, name, parameter) of every free one."""
        return tuple(
            (k, name, effect.declared[name])
            for k, effect in enumerate(self.effects)
            for name in effect.free(effect.site)
        )

    @property
    def start(self) -> Array:
        """Scaled starting values, (p,)."""
        return np.array([p.coordinate(self.effects[k].values[name]) for k, name, p in self.parameters])

    def at(self, scaled: Array) -> tuple[Effect, ...]:
        """The effects at scaled values, (p,)."""
        values = [dict(effect.values) for effect in self.effects]
        for (k, name, parameter), size in zip(self.parameters, scaled):
            values[k][name] = parameter.value(float(size))
        return tuple(type(e)(e.site, **v) for e, v in zip(self.effects, values))

    def bounds(self) -> tuple[Array, Array]:
        """Smallest and largest scaled values, (p,) each."""
        ends = [sorted((p.coordinate(p.low), p.coordinate(p.high))) for *_, p in self.parameters]
        return np.array([low for low, _ in ends]), np.array([high for _, high in ends])

    def steps(self, scaled: Array) -> tuple[Array, list[tuple[Effect, ...]]]:
        """A small step of every parameter that its bounds allow, (p,), and the effects after each of them alone."""
        steps = np.where(scaled + STEP <= self.bounds()[1], STEP, -STEP)
        return steps, [self.at(scaled + step * row) for step, row in zip(steps, np.eye(len(steps)))]

    def simpler(self) -> Iterator["Candidate"]:
        """Without one of several effects, or with one where it has fewer parameters, as roll for roll and pitch.

        Or with a special case of it that has fewer.
        """
        for one in self.effects:
            others, kind = tuple(e for e in self.effects if e is not one), type(one)
            if others:
                yield Candidate(others)
            for site in _alternatives(kind, one.site):
                names = set(kind.free(site))
                if names < set(kind.free(one.site)):
                    yield Candidate((*others, kind(site, **{name: one.values[name] for name in names})))
            for case in (effect_library()[name] for name in kind.special_cases if name in effect_library()):
                names = set(case.parameters(one.site)) & set(one.values)
                if len(case.free(one.site)) < len(kind.free(one.site)):
                    yield Candidate((*others, case(one.site, **{name: one.values[name] for name in names})))

    @property
    def places(self) -> tuple[Cause, ...]:
        """What and where, without sizes: equal for equal causes."""
        return tuple(sorted(effect.cause for effect in self.effects))

    @property
    def label(self) -> str:
        return " + ".join(" ".join([e.id, *(f"{k} {v}" for k, v in e.location.items())]) for e in self.effects)


def _alternatives(kind: type[Effect], site: Site) -> tuple[Site, ...]:
    """Sites of a boom that differ in the parameters that are free there."""
    return kind.allowed(BOOM_SITES) if "boom" in site.tags else (site,)


def causes(kind: type[Effect], site: Site) -> set[tuple]:
    """What an effect is at a site, its special cases too: of two that share one, the data cannot tell the sizes.

    Where sites differ in their parameters, such as roll from roll and pitch, each parameter is a cause.
    """
    names = kind.free(site)
    divided = any(kind.free(other) != names for other in _alternatives(kind, site))
    parts = names if divided else [site.key]
    return {(name, part) for name in (kind.id, *kind.special_cases) for part in parts}


def apart(kind: type[Effect], site: Site, effects: Sequence[Effect]) -> bool:
    """Whether an effect at a site shares no cause with others, so that it can stand beside them."""
    return not any(causes(kind, site) & causes(type(other), other.site) for other in effects)


def everywhere(system: System, without: Sequence[str] = ()) -> list[Kind]:
    """Every effect of the library at every site that could be a cause, but for the ids left out."""
    kinds = (kind for kind in effect_library().values() if kind.competes and kind.id not in without)
    sites = system.sites()
    return [(kind, site) for kind in kinds for site in kind.allowed(sites)]
