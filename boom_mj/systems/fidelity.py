"""How finely a machine is simulated: levels, and what others than the middle one say of the model's own error."""

from dataclasses import dataclass
from typing import NamedTuple


class Level(NamedTuple):
    """How finely a machine is simulated.

    Attributes:
        step: of integration, in steps of the model.
        hinges: per elastic coordinate, where that is a choice.
        shaken: whether measured motion that goes in has its noise once more.
        start: number of the measured state, from 1, that is a deviation larger when a recording begins; 0 for none.
    """

    step: float
    hinges: int = 1
    shaken: bool = False
    start: int = 0


@dataclass(frozen=True)
class Refinement:
    """Levels that differ in one respect: what they say otherwise than the middle one tells how wrong that one is.

    Attributes:
        missing: what must be added to the middle level, as a sum of those differences.
        doubtful: that of which a share may be wrong, as a sum of those differences.
    """

    levels: tuple[Level, ...]
    missing: tuple[float, ...]
    doubtful: tuple[float, ...]


@dataclass(frozen=True)
class FidelityLadder:
    """Levels at which a machine is simulated.

    Attributes:
        rough: of screening, and of where fits start.
        coarse: of nuisances and first fits.
        middle: of the base of all predictions.
        checks: what they find missing adds up.
        shown: of simulated recordings for people.
        simplest: which recordings may come from that were simulated, not measured; None where there is none such.
        starts: as the middle one, each with another measured state a deviation larger when a recording begins.
        along: share of what is doubtful that may be wrong alike all along a channel.
    """

    rough: Level
    coarse: Level
    middle: Level
    checks: tuple[Refinement, ...]
    shown: Level
    along: float = 0.0
    simplest: Level | None = None
    starts: tuple[Level, ...] = ()

    @property
    def others(self) -> tuple[Level, ...]:
        """Of all checks, then of the starts."""
        return *(level for check in self.checks for level in check.levels), *self.starts
