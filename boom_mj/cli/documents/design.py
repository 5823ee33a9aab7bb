"""Of the design of an experiment."""

from typing import Any

from boom_mj.cli.documents.part import Number, Part


class Outlook(Part):
    """What an experiment is expected to tell."""

    separation: Number
    """Of the closest two explanations, standard deviations; null of one explanation."""
    probability: Number
    """That the right one of two will have on average."""
    gain: Number
    """What is made large: the square of the separation, or the log determinant of the information on sizes."""


class KnownOutlook(Outlook):
    """That of an experiment of the catalogue."""

    name: str


class SizeLeft(Part):
    """How well a size will be known."""

    id: str
    location: dict[str, Any]
    parameter: str
    left: Number
    """Width of its interval after the experiment over that before."""


class GapDesign(Part):
    """gap design ANSWER.json --json FILE"""

    sentence: str
    explanations: list[str]
    designed: Outlook
    sizes: list[SizeLeft]
    catalogue: KnownOutlook | None
    """The best of the catalogue that is as short; null where none can be done."""
    random: Outlook | None
    """The median of those that were drawn."""
    experiment: dict[str, Any]
