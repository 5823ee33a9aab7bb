"""Of the discovery of a law."""

from typing import Any, Literal

from boom_mj.cli.documents.calibration import Levels
from boom_mj.cli.documents.gap import SizedParameter
from boom_mj.cli.documents.logs import Finding
from boom_mj.cli.documents.part import Number, Part


class Formula(Part):
    """A law with its numbers in it."""

    formula: str
    place: dict[str, Any]
    acts_on: str
    terms: list[str]
    holdout_gap: Number


class Law(Part):
    """The law of a discovery."""

    place: dict[str, Any]
    acts_on: str
    formula: str
    terms: list[str]
    parameters: dict[str, SizedParameter]
    same_as: str | None
    """Id of the effect in the library that does the same."""


class PlaceClosure(Part):
    """What the best law of a place closes."""

    place: dict[str, Any]
    acts_on: str
    closure: Number


class History(Part):
    """At every time."""

    value: list[Number]
    deviation: list[Number]


class ForceHistory(Part):
    """A force over time in one recording; besides, by direction, its `value` and standard `deviation`."""

    recording: str
    time: list[Number]
    up: History | None = None
    left: History | None = None
    positive: History | None = None


class PlaceForce(Part):
    """What a force in time at a place, of no formula, would close."""

    acts_on: str
    unit: str
    closure: Number
    """Of channels that had no part in its estimate."""
    closure_interval: list[Number]
    histories: list[ForceHistory]
    """By held-out recording; of the best place only."""


class LibraryBest(Part):
    """The effect of the library that does best alone."""

    id: str
    location: dict[str, Any]
    holdout_gap: Number


class LawGaps(Part):
    """Gaps in units of noise."""

    train: Levels
    holdout: Levels
    closure: Number
    closure_interval: list[Number]


class GapDiscover(Part):
    """gap discover LOGS... --json FILE"""

    verdict: Literal["law", "none"]
    sentence: str
    law: Law | None
    gap: LawGaps
    front: list[Formula]
    """The best of every length."""
    ties: list[Formula]
    places: list[PlaceClosure]
    forces: list[PlaceForce]
    """Best place first; only where nothing explains the gap, or where asked for."""
    library: LibraryBest | None
    withheld: str | None
    """Id of an effect that was left out of the library and leaves less than the law."""
    data: list[Finding]
    complete: bool
    skipped: list[str]
    provenance: dict[str, Any]
