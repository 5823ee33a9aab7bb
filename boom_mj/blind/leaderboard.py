"""One row of figures a method, as a table of several has it."""

from collections.abc import Mapping, Sequence

from boom_mj.blind.figures import Figure

COLUMNS: Mapping[str, str] = {
    "single effect: right id and location": "single: id and place",
    "two effects: both named and placed": "two: both",
    "three to five effects: recall": "three to five: recall",
    "three to five effects: precision": "precision",
    "single effect on a machine as built: right id and location": "single, as built",
    "false alarm without effect": "false alarms",
    "withheld or outside the library: unexplained or tied with a twin": "withheld or unlisted",
    "95 % intervals that hold the truth": "intervals hold",
    "probability of an answer: Brier score": "Brier score",
    "probability of an answer: expected calibration error": "calibration error",
    "time of one case on one core, median, s": "median s",
}
"""Heads of the columns by the figure that each holds."""
SCORES = ("Brier score", "calibration error", "median s")  # no shares


def leaderboard_row(method: str, figures: Sequence[Figure]) -> dict[str, str]:
    """What a table holds of a method, by column: shares in per cent of how many, with their 95 % intervals."""
    measured = {figure.name: figure for figure in figures}
    return {"method": method, **{head: _cell(head, measured[name]) for name, head in COLUMNS.items()}}


def leaderboard(rows: Sequence[Mapping[str, str]]) -> str:
    """The rows as a Markdown table."""
    heads = ("method", *COLUMNS.values())
    lines = [heads, ("---",) * len(heads), *(tuple(row[head] for head in heads) for row in rows)]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def _cell(head: str, figure: Figure) -> str:
    if not figure.count:
        return "-"
    if head in SCORES:
        return f"{figure.value:.2g} ({figure.low:.2g} to {figure.high:.2g})"
    return f"{figure.value:.0%} of {figure.count} ({figure.low:.0%} to {figure.high:.0%})".replace("%", " %")
