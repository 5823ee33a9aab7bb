"""Pictures of a score as SVG: the confusion matrix, the reliability diagram."""

from collections.abc import Sequence
from html import escape

from boom_mj.blind.figures import given_and_true, wilson
from boom_mj.blind.grading import Outcome
from boom_mj.blind.probabilities import Bin, reliability

CELL, LABEL, HEAD, SLANT = 22, 240, 170, 100  # px: of a count, of names at the left, above, and what those lean over
BLUE, VERMILION, INK = "#0072b2", "#d55e00", "#222222"  # right, wrong, text
VERDICTS = ("consistent", "unexplained", "no answer")
_KINDS = ("single", "clutter", "none", "withheld", "stranger")
SIDE, LEFT, TOP = 240, 46, 10  # px: of the reliability diagram, and where it begins


def confusion_svg(outcomes: Sequence[Outcome]) -> str:
    """The confusion matrix of all cases with one effect or none, as SVG: a row per truth, a column per answer."""
    shown = [o for o in outcomes if o.kind not in ("pair", "several")]
    rows = sorted({_row(o) for o in shown}, key=lambda row: (_KINDS.index(row[0]), row[1]))
    names = sorted({_column(o) for o in shown} - set(VERDICTS))
    columns = [*names, *(v for v in VERDICTS if any(_column(o) == v for o in shown))]
    width, height = LABEL + CELL * len(columns) + SLANT, HEAD + CELL * len(rows) + 10
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" viewBox="0 0 {width} {height}" '
        f'font-family="sans-serif" font-size="11" fill="{INK}">',
        f'<rect width="{width}" height="{height}" fill="white"/>',
    ]
    for k, column in enumerate(columns):
        x = LABEL + CELL * (k + 0.65)
        parts.append(f'<text transform="translate({x:.0f},{HEAD - 6}) rotate(-60)">{escape(column)}</text>')
    for j, row in enumerate(rows):
        y = HEAD + CELL * j
        label = row[1] if row[0] in ("single", "none") else f"{row[0]}: {row[1]}"
        parts.append(f'<text x="{LABEL - 6}" y="{y + 15}" text-anchor="end">{escape(label)}</text>')
        own = [o for o in shown if _row(o) == row]
        for k, column in enumerate(columns):
            there = [o for o in own if _column(o) == column]
            colour, strength = BLUE if there and there[0].right else VERMILION, 0.25 + 0.75 * len(there) / len(own)
            fill = f'fill="{colour}" fill-opacity="{strength:.2f}"' if there else 'fill="#f4f4f4"'
            x = LABEL + CELL * k
            parts.append(f'<rect x="{x}" y="{y}" width="{CELL - 1}" height="{CELL - 1}" {fill}/>')
            if there:
                parts.append(f'<text x="{x + CELL / 2}" y="{y + 15}" text-anchor="middle">{len(there)}</text>')
    return "".join([*parts, "</svg>"])


def _row(outcome: Outcome) -> tuple[str, str]:
    return outcome.kind, outcome.truth


def _column(outcome: Outcome) -> str:
    return "several effects" if " + " in outcome.answer else outcome.answer


def reliability_svg(outcomes: Sequence[Outcome]) -> str:
    """The reliability diagram: the share of answers that is true over the probability given, bin by bin."""
    left, bottom, right = LEFT, TOP + SIDE, LEFT + SIDE
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{right + 24}" height="{bottom + 46}" font-family="sans-serif" '
        f'font-size="11" fill="{INK}"><rect width="100%" height="100%" fill="white"/>',
        f'<rect x="{left}" y="{TOP}" width="{SIDE}" height="{SIDE}" fill="none" stroke="#ccc"/>',
        f'<line x1="{left}" y1="{bottom}" x2="{right}" y2="{TOP}" stroke="#999" stroke-dasharray="4"/>',
        f'<text x="{left + SIDE / 2}" y="{bottom + 36}" text-anchor="middle">probability given</text>',
        f'<text transform="translate(12,{TOP + SIDE / 2}) rotate(-90)" text-anchor="middle">share that is true</text>',
    ]
    for tick in (0, 0.25, 0.5, 0.75, 1):
        parts.append(f'<text x="{left + SIDE * tick}" y="{bottom + 16}" text-anchor="middle">{tick:g}</text>')
        parts.append(f'<text x="{left - 6}" y="{_height(tick) + 4}" text-anchor="end">{tick:g}</text>')
    return "".join([*parts, *map(_bin, reliability(*given_and_true(outcomes))), "</svg>"])


def _bin(one: Bin) -> str:
    """A dot at the share, a line along its 95 % interval, the number of answers."""
    x, (low, high) = LEFT + SIDE * one.probability, wilson(round(one.true * one.count), one.count)
    return (
        f'<line x1="{x:.1f}" y1="{_height(low):.1f}" x2="{x:.1f}" y2="{_height(high):.1f}" stroke="{BLUE}"/>'
        f'<circle cx="{x:.1f}" cy="{_height(one.true):.1f}" r="4" fill="{BLUE}"/>'
        f'<text x="{x + 6:.1f}" y="{_height(one.true) + 4:.1f}">{one.count}</text>'
    )


def _height(share: float) -> float:
    return TOP + SIDE * (1 - share)
