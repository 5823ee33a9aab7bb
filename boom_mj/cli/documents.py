"""What `--json` writes, by command: keys that stay; required ones are in every document, which may hold more."""

from typing import Any, Literal

from pydantic import BaseModel, ConfigDict

Number = float | None
"""null where it is unknown or not finite."""


class Part(BaseModel):
    """A part of a document, which may hold more."""

    model_config = ConfigDict(extra="allow", strict=True, use_attribute_docstrings=True)


class Generate(Part):
    """generate MACHINE -o MODEL --json"""

    machine: str
    model: str
    """The file."""
    format: Literal["mjcf", "urdf"]
    hinges: int
    degrees_of_freedom: int
    keyframes: list[str]
    sensors: list[str]


class Box(Part):
    """Smallest and largest value."""

    min: float
    max: float


class Simulate(Part):
    """simulate MACHINE EXPERIMENT --json; of a sweep see `Sweep`"""

    machine: str
    experiment: str
    simulated_s: float
    steps: int
    recording: str | None
    """The file, if one was written."""
    tip_m: dict[Literal["start", "end", "range"], list[float]]
    """x, y, z in the world."""
    cylinders_n: dict[str, Box]


class Sweep(Part):
    """simulate MACHINE EXPERIMENT --sweep RANGE -o DIR --json"""

    machine: str
    experiment: str
    folder: str
    table: str
    points: int
    recorded: int
    failed: dict[str, str]
    """What went wrong, by point."""


class ChannelGroup(Part):
    """Log and twin in one channel group, such as imu/link5/specific_force/y."""

    rms: Number
    """Of measured - simulated, in `unit`."""
    noise: float
    ratio: Number
    unit: str


class ChannelQuality(Part):
    """One channel of a log."""

    noise: Number
    expected_noise: Number
    excitation: Number


class SignalQuality(Part):
    """One signal of a log."""

    rate_hz: Number
    samples_per_period: Number
    missing: float
    longest_gap_s: float
    longest_gap_at_s: float
    channels: dict[str, ChannelQuality]


class Quality(Part):
    """A log, judged before it drives a model."""

    modes_hz: list[float]
    remarks: list[str]
    signals: dict[str, SignalQuality]


class Timing(Part):
    """What a replay took."""

    simulated_s: float
    steps: int
    loop_wall_s: float


class Replay(Part):
    """replay LOG --json"""

    log: str
    machine: str
    groups: dict[str, ChannelGroup]
    timing: Timing
    quality: Quality


class Validate(Part):
    """validate MACHINE --json"""

    machine: str
    poses: int
    hinges: dict[str, dict[str, Any]]
    """By number of hinges: worst and median relative difference of every figure."""


class View(Part):
    """view WHAT --record FILM --json"""

    film: str
    pictures: int
    pictures_per_s: float
    speed: float
    exaggerate: float


class Render(Part):
    """render WHAT -o DIR --json"""

    folder: str
    frames: int
    cameras: list[str]
    layouts: list[str]


class TrackedMarker(Part):
    """One marker."""

    marker: int
    share: float
    """Of the frames in which it has a position."""
    deviation_m: list[Number]


class Track(Part):
    """track DIR --json"""

    frames: int
    cameras: dict[str, dict[str, Any]]
    markers: list[TrackedMarker]
    contradictory: int


class LogTopic(Part):
    """One topic of a log."""

    topic: str
    type: str
    encoding: str
    messages: int
    time_base: str
    fields: dict[str, dict[str, Any]]
    findings: list[str]


class LogsInspect(Part):
    """logs inspect LOG --json"""

    log: str
    format: str
    labels: dict[str, str]
    warnings: list[str]
    topics: list[LogTopic]
    map: str
    """The proposed topic map, as TOML."""


class Interval(Part):
    """A size with the ends of its 95 % interval; null where an end is open."""

    value: float
    low: Number
    high: Number


class CalibratedParameter(Interval):
    """A parameter of the machine file."""

    name: str
    unit: str
    file: float
    factor: float
    held: bool
    """Not told by the logs: as the file has it, or joined with others."""


class Finding(Part):
    """Something wrong with a log."""

    log: str
    channel: str
    kind: str
    from_s: Number
    to_s: Number
    evidence: str
    action: str
    used: bool
    finding: str
    """All of it in one sentence."""
    repair: str | None
    """What a topic map would have to say."""


class LogsCheck(Part):
    """logs check LOGS... --json FILE"""

    data: list[Finding]


class Levels(Part):
    """A gap in units of noise, before and after; 1 is the floor."""

    before: Number
    after: Number
    floor: float


class Identifiability(Part):
    """What the recordings tell."""

    rank: int
    of: int
    condition: Number
    correlated: list[Any]
    null_directions: list[Any]


class Calibrate(Part):
    """calibrate MACHINE LOGS... --json FILE"""

    machine: str
    sentence: str
    parameters: list[CalibratedParameter]
    zero_offsets_deg: list[Interval]
    not_told: list[str]
    at_bound: list[str]
    identifiability: Identifiability
    gap: Levels
    validation: dict[str, Any]
    provenance: dict[str, Any]


class CalibratePlan(Part):
    """calibrate MACHINE LOGS... --plan --json FILE"""

    sentence: str
    parameter: str
    before: Number
    proposals: list[dict[str, Any]]
    untold: list[str]


class SizedParameter(Interval):
    """A parameter of an effect."""

    unit: str


class Named(Part):
    """An effect at its place."""

    id: str
    location: dict[str, Any]


class NamedCause(Named):
    """A cause."""

    parameters: dict[str, SizedParameter]
    closure_alone: Number
    share: Number
    """Of the nominal held-out mean square."""
    share_interval: list[Number]
    probability: Number


class Rival(Named):
    """An explanation that lost."""

    holdout_gap: Number
    why_not: str
    probability: Number


class Gaps(Part):
    """Gaps in units of noise."""

    train: Levels
    holdout: Levels
    closure: Number
    closure_interval: list[Number]
    fidelity_alone: Number


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


class Remainder(Part):
    """What an explanation leaves above the floor."""

    share: Number
    looks_like: str
    where: str


class GapDiagnose(Part):
    """gap diagnose LOGS... --json FILE; from Python `Answer.document`"""

    verdict: Literal["consistent", "explained", "ambiguous", "partial", "unexplained"]
    sentence: str
    effects: list[NamedCause]
    rivals: list[Rival]
    ties: list[list[Named]]
    next_experiment: str | None
    gap: Gaps
    where: list[Where]
    provenance: dict[str, Any]
    others: dict[Literal["outside_library", "none"], Number]
    """Probabilities beside those of the explanations."""
    budget: list[Share]
    remainder: Remainder | None
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


class EffectParameter(Part):
    """A parameter of an effect in the library."""

    unit: str
    neutral: Number
    low: Number
    high: Number


class LibraryEffect(Part):
    """An effect in the library."""

    id: str
    physics: str
    locations: list[dict[str, Any]]
    """On a boom."""
    at: list[str]
    needs: list[str]
    parameters: dict[str, EffectParameter]
    """On a boom; on any other machine they depend on its model and logs."""
    confused_with: list[str]
    separating_experiment: str


class GapEffects(Part):
    """gap effects --json"""

    effects: list[LibraryEffect]


class Criterion(Part):
    """A number that decides, by kind of machine."""

    family: str
    name: str
    unit: str
    reason: str
    value: dict[str, Number]


class GapCriteria(Part):
    """gap criteria --json"""

    criteria: list[Criterion]


class GapBlindMake(Part):
    """gap blind make --json"""

    cases: int
    folder: str
    seal: str
    seal_sha256: str


class GapBlindRun(Part):
    """gap blind run DIR --json"""

    cases: int
    answers: str


class BlindFigure(Part):
    """A figure with its 95 % interval and goal."""

    name: str
    value: Number
    low: Number
    high: Number
    count: int
    goal: list[Number] | None
    met: bool | None


class GapBlindScore(Part):
    """gap blind score DIR... --json FILE"""

    figures: list[BlindFigure]
    campaigns: list[dict[str, Any]]
    outcomes: list[dict[str, Any]]
    seal_sha256: list[str] | dict[str, str] | str
    seed_sha256: list[str] | dict[str, str] | str
    leaderboard: dict[str, str] | None
    """By column, the row of a table of methods; null without `--method`."""


DOCUMENTS: dict[str, tuple[type[Part], ...]] = {
    "generate": (Generate,),
    "simulate": (Simulate, Sweep),
    "replay": (Replay,),
    "validate": (Validate,),
    "view": (View,),
    "render": (Render,),
    "track": (Track,),
    "calibrate": (Calibrate, CalibratePlan),
    "logs inspect": (LogsInspect,),
    "logs check": (LogsCheck,),
    "gap diagnose": (GapDiagnose,),
    "gap effects": (GapEffects,),
    "gap criteria": (GapCriteria,),
    "gap watch": (GapWatch,),
    "gap blind make": (GapBlindMake,),
    "gap blind run": (GapBlindRun,),
    "gap blind score": (GapBlindScore,),
}
"""Documents by command; of several, which one depends on the options."""
