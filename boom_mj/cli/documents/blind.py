"""Of sealed cases."""

from typing import Any

from boom_mj.cli.documents.part import Number, Part


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
