"""Effects: what a machine has and the nominal model lacks.

An effect is a term with parameters p whose neutral value p0 makes it vanish to the last byte of the MJCF and of the
recording, so that "off" needs no branch and hypotheses add up. It acts in one of two ways: a `ModelEffect` edits the
MuJoCo specification, a `SignalEffect` alters what the sensors say. One effect is one file in `library/`; being there is
being registered.
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from importlib import import_module
from pkgutil import iter_modules
from typing import ClassVar

import mujoco

from boom_mj.errors import EffectError
from boom_mj.machine import Machine
from boom_mj.recording import Recording


@dataclass(frozen=True)
class Parameter:
    """A number that an effect takes: its unit, the value at which the effect vanishes, and its bounds."""

    unit: str
    neutral: float
    low: float
    high: float


class Effect(ABC):
    """Common to both kinds: a name, parameters, and the docstring with the physics and what it is confused with."""

    id: ClassVar[str]
    parameters: ClassVar[Mapping[str, Parameter]]

    def __init__(self, **values: float) -> None:
        unknown = [name for name in values if name not in self.parameters]
        if unknown:
            raise EffectError(f"effect {self.id} has no parameter {unknown[0]!r}; it has: {', '.join(self.parameters)}")
        for name, value in values.items():
            bound = self.parameters[name]
            if not bound.low <= value <= bound.high:
                raise EffectError(
                    f"effect {self.id}: {name} = {value:g} {bound.unit} is outside [{bound.low:g}, {bound.high:g}]"
                )
        self.values = {name: values.get(name, bound.neutral) for name, bound in self.parameters.items()}


class ModelEffect(Effect):
    """An effect that MuJoCo simulates."""

    @abstractmethod
    def edit(self, spec: mujoco.MjSpec, machine: Machine) -> None:
        """Change the specification in place."""


class SignalEffect(Effect):
    """An effect of the sensors alone."""

    @abstractmethod
    def alter(self, recording: Recording) -> Recording:
        """The recording as the affected sensors would have made it."""


def library() -> Mapping[str, type[Effect]]:
    """Every effect of `library/`, by id."""
    package = import_module("boom_mj.effects.library")
    for module in iter_modules(package.__path__):
        import_module(f"boom_mj.effects.library.{module.name}")
    kinds = (*ModelEffect.__subclasses__(), *SignalEffect.__subclasses__())
    return {kind.id: kind for kind in sorted(kinds, key=lambda kind: kind.id) if "library" in kind.__module__}


def parse_effect(text: str) -> Effect:
    """An effect from `ID:key=value,...`.

    Raises:
        EffectError: unknown effect or parameter, or a value that is no number or out of bounds.
    """
    name, _, rest = text.partition(":")
    known = library()
    if name not in known:
        raise EffectError(f"no effect {name!r}; the library holds: {', '.join(known) or 'none yet'}")
    values = {}
    for pair in filter(None, rest.split(",")):
        key, _, value = pair.partition("=")
        try:
            values[key.strip()] = float(value)
        except ValueError as error:
            raise EffectError(f"effect {name}: {pair!r} should read key=number") from error
    return known[name](**values)
