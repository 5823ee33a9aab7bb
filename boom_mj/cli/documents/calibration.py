"""Of a calibration."""

from typing import Any

from boom_mj.cli.documents.part import Number, Part


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
