"""What the diagnosis needs to know of a machine: what it says under a hypothesis, and what could differ in it.

The method - campaign, metric, screening, contest, judgement, answer - sees a machine through `System` alone. A boom is
one (`boom.py`), an MJCF file with a channel map is another (`mjcf/`).
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

import numpy as np

from boom_mj.effects import Effect
from boom_mj.recording import Recording, Signal

if TYPE_CHECKING:
    from boom_mj.diagnosis.linearisation import Metric

Array = np.ndarray
Hypothesis = tuple[Effect, ...]
Band = tuple[str, float]  # name, upper edge in Hz


@dataclass(frozen=True)
class Nuisance:
    """A nuisance: the hypothesis whose effect is its column, and its prior deviation in units of that hypothesis.

    Attributes:
        still: whether its column hardly depends on how the machine swings.
    """

    hypothesis: Hypothesis
    deviation: float
    still: bool = False

    def beside(self, effects: Hypothesis) -> "Nuisance":
        """What is left of it in a machine that has effects: the size of an effect is all there is of its cause."""
        causes = {effect.cause for effect in effects}
        return replace(self, hypothesis=tuple(e for e in self.hypothesis if e.cause not in causes))


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
        coarse: of nuisances and the contest.
        middle: of the base of all predictions.
        checks: what they find missing adds up.
        shown: of twins.
        alike: share of what is doubtful that may be wrong alike all along a channel.
    """

    rough: Level
    coarse: Level
    middle: Level
    checks: tuple[Refinement, ...]
    shown: Level
    alike: float = 0.0


@dataclass(frozen=True)
class ResidualForce:
    """A residual force, root mean square over all recordings.

    Attributes:
        part: such as link2 or cylinder3.
        direction: such as v, w or torsion of a link.
        force: in `unit`.
        ratio: to what noise and model error alone would ask for.
    """

    part: str
    direction: str
    force: float
    unit: str
    ratio: float


@dataclass(frozen=True)
class Words:
    """How people speak of a kind of machine.

    Attributes:
        phases: words of `System.phases`, in their order.
        learnt: what `System.learns` learns.
        finer: what a finer model has.
        zero: id of the tolerance that is a sensor's zero offset.
        frames: which way directions point.
    """

    phases: tuple[str, ...]
    learnt: str
    finer: str
    zero: str
    frames: str = ""


class System(ABC):
    """A machine to be diagnosed.

    Attributes:
        block: over which channels are averaged, s.
        window: beyond which residuals count as independent, s.
        bands: frequency bands in which a gap is told, lowest first.
        still: speed below which a coordinate of `motion` is at rest, in its unit.
        causes: most effects that an explanation may have.
        slack: share of the gap that an explanation may leave besides noise.
        worth: share of the remaining gap that another effect must close.
        spill: share of the mean square that effects took away, which their own inaccuracy may leave.
        hides: gap above which an explanation that suffices may hide another cause.
        words: for people.
        repeat: period of a motion that the recordings repeat, s, if they do.
        swings: whether it vibrates so long that fits of its recordings have minima of their own.
        listening: signal in which periodic effects show as spectral lines, if there is one.
    """

    block: float
    window: float
    bands: tuple[Band, ...]
    still: float
    fidelity: FidelityLadder
    causes: int
    slack: float
    worth: float
    spill: float
    words: Words
    hides: float = np.inf
    repeat: float | None = None
    swings: ClassVar[bool] = False
    listening: ClassVar[str | None] = None

    @property
    @abstractmethod
    def name(self) -> str:
        """Of the machine."""

    @property
    @abstractmethod
    def provenance(self) -> Mapping[str, Any]:
        """What else the answer should say of how the machine was simulated."""

    @abstractmethod
    def library(self) -> list[tuple[type[Effect], dict]]:
        """Every effect at every place that could be a cause."""

    @abstractmethod
    def tolerances(self) -> tuple[Nuisance, ...]:
        """What differs between healthy machines, all of it small."""

    @abstractmethod
    def noise(self) -> Mapping[str, Array]:
        """Least noise of a sample by signal, one per channel, (k,); the signals named are those compared."""

    @abstractmethod
    def clock(self, log: Recording) -> tuple[float, float]:
        """When a recording begins and how long it lasts, s."""

    @abstractmethod
    def split(self, hypothesis: Hypothesis) -> tuple[Hypothesis, Hypothesis]:
        """Effects that must be simulated, and those that alter simulated signals afterwards."""

    @abstractmethod
    def simulate(self, hypothesis: Hypothesis, level: Level, index: int, log: Recording) -> dict[str, Signal]:
        """Densely sampled ideal signals, by name, times from 0; called by several threads at a time.

        Args:
            level: of fidelity.
            index: of the recording, for caches.

        Raises:
            BoomError: the hypothesis has no simulation.
        """

    @abstractmethod
    def altered(self, effects: Hypothesis, signals: Mapping[str, Signal]) -> dict[str, Signal]:
        """Dense signals as sensors with effects give them; untouched ones are the same objects."""

    @abstractmethod
    def group(self, signal: str, values: Signal, column: int) -> str:
        """Name of the channel group of a column."""

    @abstractmethod
    def place(self, group: str) -> tuple[str, str, str]:
        """Sensor, link and direction of a channel group; the direction is "" where there is but one."""

    @abstractmethod
    def place_name(self, sensor: str, link: str) -> str:
        """A sensor at its place, for people."""

    @abstractmethod
    def group_name(self, group: str) -> str:
        """A channel group, for people."""

    @abstractmethod
    def motion(self, log: Recording, time: Array) -> Array:
        """Measured coordinates at times from the recording's start, (n, k)."""

    @abstractmethod
    def phases(self, log: Recording) -> Array:
        """What happens in every block of a recording, (n,) of words."""

    @abstractmethod
    def next_experiment(self, explanations: Sequence[Hypothesis], done: Sequence[str]) -> str | None:
        """What would separate explanations that tie; None where nothing is known."""

    @abstractmethod
    def pushes(self, metric: "Metric", residual: Array) -> tuple[ResidualForce, ...]:
        """Residual forces that a whitened residual (N,) asks for, largest ratio first; none where nothing is known."""

    @abstractmethod
    def learns(self, time: Array, lasts: Array) -> Array:
        """What to learn from in a recording that is not learnt from as a whole, (n,) of bool.

        Args:
            time: from the recording's start, (n,), s.
            lasts: the recording, (n,), s.
        """

    @abstractmethod
    def shortcut(self, probe: Effect) -> Callable[["Metric"], Array] | None:
        """What makes the whitened column (N,) of a probe that needs no simulation of its own; None where it does."""
