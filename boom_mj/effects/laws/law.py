"""What all laws have in common."""

from collections.abc import Mapping, Sequence
from typing import ClassVar

import numpy as np

from boom_mj.effects.base import Array, Effect
from boom_mj.effects.site import Site

TEMPERATURE = {"temperature": "degC"}
"""A variable of joints and channels of an MJCF machine, where its map has a channel of that role."""


def direction(speed: Array, creep: float) -> Array:
    """The sign of a speed, which it changes smoothly over a small one: dry friction over its force, (n,)."""
    return np.tanh(speed / creep)


class Law(Effect):
    """Common to all laws.

    Attributes:
        formula: for people.
        variables: arguments of `law` by name, with their units.
        unit: of what `law` gives.
    """

    formula: ClassVar[str] = ""
    variables: ClassVar[Mapping[str, str]] = {}
    unit: ClassVar[str] = ""

    @property
    def silent(self) -> bool:
        """Whether it does nothing."""
        return not any(self.values[name] for name, p in self.declared.items() if p.neutral == 0)

    @classmethod
    def allowed(cls, sites: Sequence[Site]) -> tuple[Site, ...]:
        """Where a temperature is logged, if it is of one."""
        needed = TEMPERATURE.keys() & cls.variables.keys()
        return tuple(site for site in super().allowed(sites) if needed <= site.tags)
