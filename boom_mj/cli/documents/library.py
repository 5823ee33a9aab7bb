"""Of what a diagnosis knows: effects and criteria."""

from typing import Any

from boom_mj.cli.documents.part import Number, Part


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
