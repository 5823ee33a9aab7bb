"""Effects: what a machine has and the nominal model lacks.

An effect is a term with parameters p whose neutral value p0 makes it vanish to the last byte of the MJCF and of the
recording, so that "off" needs no branch and hypotheses add up. It is plain data: a site and values. What it acts on is
its type:

    MachineEffect   changes numbers of a boom's machine file
    ModelEffect     edits the MuJoCo specification
    ForceEffect     pushes on sites or joints of the model while it moves
    InputEffect     stands between what is true of an input and what is logged or commanded: y(t) = apply(u(t))
    OutputEffect    alters what compared sensors say

The kinds are in `kinds`. One effect is one file in `library/`, or a class of another package; the diagnosis sees it as
a point in the space of its parameters, each scaled as `Parameter` says.
"""

from abc import ABC
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from boom_mj.effects.parameter import Parameter, behind
from boom_mj.effects.site import Site
from boom_mj.errors import EffectError

Array = np.ndarray
"""Of numbers; shapes stand in docstrings."""
Values = Mapping[str, float]
"""Sizes of parameters by name, in their units."""
Cause = tuple[str, tuple[tuple[str, int | str], ...]]  # id and site, without sizes
DETUNING = 0.5, 1.0, 2.0
"""`Effect.sizes` of what changes frequencies: each size turns the phase of what swings by another angle."""


@dataclass(frozen=True, eq=False, repr=False, init=False)
class Effect(ABC):
    """Common to all kinds: a name, where it can be, parameters, what it is confused with and what tells them apart.

    Attributes:
        at: keys of the sites where it may be, such as ("link", "axis"); () is the machine as a whole.
        needs: tags that a site must have.
        table: parameters by name, where they are the same at every site.
        confused_with: ids of what looks alike.
        special_cases: ids of effects that it becomes at some of its values.
        separating_experiment: that tells it from those: of the catalogue, or in words.
        sizes: scaled, at which screening looks; several, and both signs, where the effect is not smooth.
        grid_start: scaled, between which a fit is begun at the least cost, where it has many minima.
        shapes: parameters that say how it acts, not how much: it is nothing where the others are neutral.
        competes: whether it can be a cause; what every log has, such as a zero offset, is estimated along instead.
        site, values: of this instance; parameters left out are neutral.
    """

    id: ClassVar[str]
    at: ClassVar[tuple[str, ...]] = ()
    needs: ClassVar[frozenset[str]] = frozenset()
    table: ClassVar[Mapping[str, Parameter]] = {}
    confused_with: ClassVar[tuple[str, ...]] = ()
    special_cases: ClassVar[tuple[str, ...]] = ()
    separating_experiment: ClassVar[str] = ""
    sizes: ClassVar[tuple[float, ...]] = (1.0,)
    grid_start: ClassVar[tuple[float, ...]] = ()
    shapes: ClassVar[frozenset[str]] = frozenset()
    competes: ClassVar[bool] = True

    site: Site
    values: Values

    def __init__(self, site: Site | None = None, **values: float) -> None:
        site = site or Site()
        declared = self.parameters(site)
        for name, value in values.items():
            if name not in declared:
                raise EffectError(f"effect {self.id} has no parameter {name!r}; it has: {', '.join(declared)}")
            low, high = declared[name].bounds
            if not low <= value <= high:
                unit = behind(declared[name].unit)
                raise EffectError(f"effect {self.id}: {name} = {value:g}{unit} is outside [{low:g}, {high:g}]")
        object.__setattr__(self, "site", site)
        object.__setattr__(self, "values", {k: float(values.get(k, p.neutral)) for k, p in declared.items()})

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Effect) and self.key == other.key

    def __hash__(self) -> int:
        return hash(self.key)

    def __repr__(self) -> str:
        pairs = [*self.site.key, *((k, f"{v!r}") for k, v in self.values.items())]
        return f"{self.id}:{','.join(f'{k}={v}' for k, v in pairs)}"

    @property
    def location(self) -> dict[str, int | str]:
        """Where it is, as answers say it."""
        return self.site.location

    @property
    def declared(self) -> Mapping[str, Parameter]:
        """Its parameters at its site."""
        return self.parameters(self.site)

    @property
    def cause(self) -> Cause:
        """What and where, without sizes: equal for equal causes."""
        return self.id, self.site.key

    @property
    def key(self) -> tuple[Any, ...]:
        """Id, site and values, by which effects are equal."""
        return *self.cause, tuple(sorted(self.values.items()))

    def basis(self, time_s: float) -> "Effect | None":
        """Where part of what it does follows an input in time that no log tells: it with a unit of that input instead.

        The unit is a hat that rises from 0 to 1 within `latent_input.KNOT_S` before the time and falls as fast.
        """
        return None

    def with_latent(self, strength: float) -> dict[str, float]:
        """What its parameters are if a latent input of this strength (standard deviation in units) comes on top."""
        return {}

    @property
    def latent_limit(self) -> float:
        """Strength of the latent inputs that its values allow."""
        return 0.0

    @classmethod
    def parameters(cls, site: Site) -> Mapping[str, Parameter]:
        """Parameters by name, with bounds and typical sizes at a site."""
        return cls.table

    @classmethod
    def allowed(cls, sites: Sequence[Site]) -> tuple[Site, ...]:
        """Of a machine's sites those where the effect can be."""
        return tuple(site for site in sites if site.keys == cls.at and cls.needs <= site.tags)

    @classmethod
    def free(cls, site: Site) -> tuple[str, ...]:
        """Parameters that a fit may change at a site."""
        return tuple(cls.parameters(site))

    @classmethod
    def screening(cls, site: Site, lines_hz: Sequence[float] = ()) -> list[list[dict[str, float]]]:
        """Where screening looks: alternatives, each of one or more values whose effects add up linearly.

        Args:
            lines_hz: frequencies that stand out of the residual.
        """
        declared = cls.parameters(site)
        return [[{name: declared[name].value(size)} for name in cls.free(site)] for size in cls.sizes]

    @classmethod
    def combine(cls, site: Site, points: Sequence[Values], weights: Array) -> dict[str, float]:
        """Values whose effect is, to first order, the weighted sum (weights (k,)) of those of screening points."""
        declared, scaled = cls.parameters(site), dict[str, float]()
        for point, weight in zip(points, weights):
            for name, value in point.items():
                scaled[name] = scaled.get(name, 0.0) + weight * declared[name].coordinate(value)
        return {name: declared[name].value(c) for name, c in scaled.items()}
