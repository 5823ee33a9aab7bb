"""Of the diagnosis of a gap."""

from typing import Any, Literal

from boom_mj.cli.documents.calibration import Interval, Levels
from boom_mj.cli.documents.logs import Finding
from boom_mj.cli.documents.part import Number, Part


class Steps(Levels):
    """A gap in units of noise, from the file to the explanation."""

    nominal: Number
    """Of the machine file as it is; `before` is as built, with the nuisances that leave least."""


class SizedParameter(Interval):
    """A parameter of an effect."""

    unit: str


class Named(Part):
    """An effect at its place."""

    id: str
    location: dict[str, Any]


class SizedCause(Named):
    """A cause with its sizes."""

    parameters: dict[str, SizedParameter]


class NamedCause(SizedCause):
    """A cause."""

    closure_alone: Number
    share: Number
    """Of the held-out mean square of the machine as built."""
    share_interval: list[Number]
    probability: Number


class TiedExplanation(Named):
    """An explanation that ties with others; `with` holds its other effects, if it has any."""

    parameters: dict[str, SizedParameter]


class Rival(Named):
    """An explanation that lost."""

    holdout_gap: Number
    why_not: str
    probability: Number


class Gaps(Part):
    """Gaps in units of noise."""

    train: Steps
    holdout: Steps
    closure: Number
    closure_interval: list[Number]
    fidelity_alone: Number
    simplest_model: Number


class Where(Part):
    """A part of the gap; the last is all others, of which only the share is told."""

    sensor: str
    share: float
    link: str | None = None
    direction: str | None = None
    band: str | None = None
    phase: str | None = None
    gap: Number = None


class Share(Named):
    """What an effect takes of the gap."""

    share: Number
    share_interval: list[Number]


class ResidualForce(Part):
    """A force that would move the machine as built to where it was."""

    part: str
    direction: str
    force: float
    unit: str
    ratio: float


class Prior(Part):
    """Of a nuisance."""

    neutral: float
    deviation: float


class NuisanceSize(Named):
    """A parameter of a nuisance, as it was estimated along."""

    parameter: str
    value: float
    unit: str
    prior: Prior


class ChannelSteps(Part):
    """A channel group of one log: rms of measured - simulated over noise, as `replay` gives it."""

    log: str
    channel: str
    data_sheet: float
    as_built: float
    with_causes: float
    uncertainty: float
    """Of with_causes, 95 %."""


class OtherLaw(Part):
    """Where a cause stands in for a law that the library lacks, and what any function of speed leaves there."""

    location: dict[str, Any]
    holdout_gap: Number


class Remainder(Part):
    """What an explanation leaves above the floor."""

    share: Number
    looks_like: str
    where: str
    other_laws: list[OtherLaw]
    train_with: list[str]


class GapDiagnose(Part):
    """gap diagnose LOGS... --json FILE; from Python `Answer.document`"""

    verdict: Literal["consistent", "explained", "ambiguous", "partial", "unexplained"]
    sentence: str
    probability: Number
    """That what it says is right as a whole."""
    effects: list[NamedCause]
    suspect: list[NamedCause]
    rivals: list[Rival]
    ties: list[list[TiedExplanation]]
    next_experiment: str | None
    gap: Gaps
    where: list[Where]
    residual_forces: list[ResidualForce]
    nuisances: list[NuisanceSize]
    channels: list[ChannelSteps]
    """None while the search runs."""
    provenance: dict[str, Any]
    others: dict[Literal["outside_library", "none", "combination"], Number]
    """Probabilities beside those of the explanations."""
    budget: list[Share]
    remainder: Remainder | None
    pushes: list[ResidualForce]
    """`residual_forces` by the name that it has in 0.1."""
    unexplained: Remainder | None
    """`remainder` by the name that it has in 0.1, with `learn_from`."""
    floor_share: Number
    """With those of budget and remainder it makes 1."""
    data: list[Finding]
    complete: bool
    skipped: list[str]
    """What was not looked at for want of time."""


class LogState(Part):
    """Whether the machine was still what it was in one log."""

    log: str
    changed: bool
    statistic: Number
    limit: Number
    group: str
    effects: list[SizedCause]
    """Of this log alone."""


class Since(Part):
    """When something changed."""

    log: str
    time_s: Number


class GapWatch(Part):
    """gap watch LOGS... --healthy LOGS... --json FILE"""

    logs: list[LogState]
    since: Since | None
    verdict: Literal["consistent", "explained", "ambiguous", "partial", "unexplained"]
    effects: list[NamedCause]
