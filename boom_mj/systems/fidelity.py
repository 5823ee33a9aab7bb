"""How finely a machine is simulated: levels, and what refining them says of the model's own error."""

from dataclasses import dataclass
from typing import NamedTuple


class Level(NamedTuple):
    """How finely a machine is simulated.

    Attributes:
        step: of integration, in steps of the model.
        hinges: per elastic coordinate, where that is a choice.
    """

    step: float
    hinges: int = 1


@dataclass(frozen=True)
class Refinement:
    """A finer level in one respect: what it says otherwise than the middle one tells how wrong that one is.

    Attributes:
        missing: what must be added to the middle level, in terms of that difference.
        doubtful: in the same terms, that of which a share may be wrong.
    """

    level: Level
    missing: float
    doubtful: float


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
        along: share of what is doubtful that may be wrong alike all along a channel.
    """

    rough: Level
    coarse: Level
    middle: Level
    checks: tuple[Refinement, ...]
    shown: Level
    along: float = 0.0
    simplest: Level | None = None
