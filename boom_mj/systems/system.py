"""What the rooms above know of a machine: seven members, and four more that some machines have.

A boom is a system (`boom/`), an MJCF file with a channel map is another (`mjcf/`).
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Any, Protocol, runtime_checkable

import numpy as np

from boom_mj.effects import Effect, Site
from boom_mj.estimation.dataset import Dataset
from boom_mj.recording import Recording, Signal
from boom_mj.systems.fidelity import FidelityLadder, Level

Array = np.ndarray
Hypothesis = tuple[Effect, ...]
Reasons = Mapping[tuple[Effect, str], str]  # why a file holds an effect, (effect, "id"), or a number, (effect, name)
NO_REASONS: Reasons = MappingProxyType({})
Band = tuple[str, float]  # name, upper edge in Hz


@dataclass(frozen=True)
class Wording:
    """How people speak of a kind of machine.

    Attributes:
        phases: words of `Timeline.phases`, in their order.
        first_part: what trains of a recording that does so in part.
        finer: what a finer model has.
        simplest: what the simplest model has, and how one gets a finer one.
        zero_offset: id of the nuisance that is a sensor's zero offset.
        frames: which way directions point.
    """

    phases: tuple[str, ...]
    first_part: str
    finer: str
    zero_offset: str
    frames: str = ""
    simplest: str = ""


@dataclass(frozen=True)
class SystemFacts:
    """What is known of a machine as plain data.

    Attributes:
        kind: of machine: "boom" or "mjcf"; criteria and pictures go by it.
        name: of the machine.
        block_s: over which channels are averaged.
        correlation_s: beyond which residuals count as independent.
        bands_hz: frequency bands in which a gap is located, lowest first.
        fidelity: levels of simulation.
        noise: least noise of a sample by signal, one per channel, (k,); the signals named are those compared.
        still: speed below which a coordinate of the timeline is at rest, in its unit.
        max_causes: most effects that are sought together where fewer do not suffice, unless asked otherwise.
        wording: for people.
        split: which entries of a recording train where it does so in part; see `Dataset.first`.
        repeat_s: period of a motion that the recordings repeat, if they do.
        oscillatory: whether it vibrates so long that fits of its recordings have minima of their own.
        line_signal: in which periodic effects show as spectral lines, if there is one.
        provenance: what else the answer should say of how the machine was simulated.
    """

    kind: str
    name: str
    block_s: float
    correlation_s: float
    bands_hz: tuple[Band, ...]
    fidelity: FidelityLadder
    noise: Mapping[str, Array]
    still: float
    max_causes: int
    wording: Wording
    split: Callable[[Array, Array], Array]
    repeat_s: float | None = None
    oscillatory: bool = False
    line_signal: str | None = None
    provenance: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Nuisance:
    """A nuisance: the hypothesis whose effect is its column, and its prior deviation in units of that hypothesis.

    Attributes:
        slow: whether its column hardly depends on how the machine swings.
    """

    hypothesis: Hypothesis
    deviation: float
    slow: bool = False

    def conditional_on(self, effects: Hypothesis) -> "Nuisance":
        """What is left of it in a machine that has effects: the size of an effect is all there is of its cause."""
        causes = {effect.cause for effect in effects}
        return replace(self, hypothesis=tuple(e for e in self.hypothesis if e.cause not in causes))


@dataclass(frozen=True)
class Timeline:
    """What happens in a recording.

    Attributes:
        start_s, duration_s: of what is simulated.
        coordinates: measured ones at times (n,) from the start, (n, q).
        phases: what happens in every block, (n,) of words.
    """

    start_s: float
    duration_s: float
    coordinates: Callable[[Array], Array]
    phases: Callable[[], Array]


@dataclass(frozen=True)
class ChannelPlace:
    """Where a channel belongs.

    Attributes:
        group: of channels that are counted together, such as "markers/link4/z".
        sensor, part, direction: of the group; the direction is "" where there is but one.
        label: of the group, for people.
        place: the sensor at its part, for people.
        device: that fails as one, as findings about data name it.
    """

    group: str
    sensor: str
    part: str
    direction: str
    label: str
    place: str
    device: str


class System(Protocol):
    """A machine: all that the rooms above know of one."""

    @property
    def facts(self) -> SystemFacts:
        """What is known of it as plain data."""

    def sites(self) -> tuple[Site, ...]:
        """Where effects may be."""

    def nuisances(self) -> tuple[Nuisance, ...]:
        """What differs between healthy machines, all of it small."""

    def timeline(self, log: Recording) -> Timeline:
        """What happens in a recording."""

    def simulate(self, hypothesis: Hypothesis, level: Level, log: Recording) -> dict[str, Signal]:
        """Densely sampled signals without output effects, by name, times from 0; called by several threads at a time.

        Raises:
            BoomError: the hypothesis has no simulation.
        """

    def observe(self, hypothesis: Hypothesis, dense: Mapping[str, Signal]) -> dict[str, Signal]:
        """Dense signals as sensors with output effects give them; untouched ones are the same objects."""

    def channel(self, signal: str, column: int) -> ChannelPlace:
        """Where a channel belongs."""


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


@runtime_checkable
class ResidualForces(Protocol):
    """A system whose channels tell where it is."""

    def forces(self, data: Dataset, white: Array, weight: Array) -> tuple[ResidualForce, ...]:
        """Forces that a whitened residual (N,) asks for, largest ratio first; weight is that of its entries, (N,)."""


@runtime_checkable
class Designs(Protocol):
    """A system that knows which experiments there are."""

    def next_experiment(self, rivals: Sequence[Hypothesis], done: Sequence[str]) -> str | None:
        """What would separate explanations that tie; None where nothing is known."""


@runtime_checkable
class Corrects(Protocol):
    """A system whose file can hold effects."""

    def corrected(self, causes: Hypothesis, nuisances: Hypothesis = (), reasons: Reasons = NO_REASONS) -> str:
        """The text of its file with effects in it: those of an explanation, and nuisances as they were estimated.

        Comments say why: cause or nuisance, and `reasons` line by line.
        """


@runtime_checkable
class LinearResponse(Protocol):
    """A system that knows what some effects do without simulating them."""

    def column(self, effect: Effect, data: Dataset, nuisances: Array) -> Array | None:
        """What an effect changes, (N,), from what nuisances change per prior deviation, (N, m); None if unknown."""


@runtime_checkable
class Individuals(Protocol):
    """A system whose copies differ by more than its nuisances."""

    def individual(self) -> tuple[Nuisance, ...]:
        """Its nuisances, with prior deviations as wide as machines are built apart."""


@runtime_checkable
class Doubts(Protocol):
    """A system that recordings tell of, not surely."""

    def doubt(self, effect: Effect, name: str) -> float:
        """How unsure a change of a parameter is because what it changes is: standard deviation, scaled."""


def separating_experiments(rivals: Sequence[Hypothesis]) -> str | None:
    """What the library says would tell rivals apart."""
    said = {e.separating_experiment for rival in rivals for e in rival if e.separating_experiment}
    return " and ".join(sorted(said)) or None
