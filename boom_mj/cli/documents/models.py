"""Of models, simulations, replays and pictures."""

from typing import Any, Literal

from boom_mj.cli.documents.part import Number, Part


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
    hinges: int
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
