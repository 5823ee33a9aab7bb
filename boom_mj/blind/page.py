"""The score for people: one page, as Markdown with its picture beside it or as HTML that fetches nothing."""

from collections.abc import Sequence
from html import escape

import numpy as np

from boom_mj.blind.figures import Figure, Score, given_and_true, held, wilson
from boom_mj.blind.grading import LISTED, Outcome
from boom_mj.blind.pictures import INK, confusion_svg, reliability_svg
from boom_mj.blind.probabilities import reliability

Table = tuple[tuple[str, ...], list[tuple[str, ...]]]
STYLE = (
    f"body{{font:15px/1.5 sans-serif;color:{INK};max-width:72em;margin:2em auto;padding:0 1em}}"
    "table{border-collapse:collapse;margin:1em 0}td,th{border:1px solid #ccc;padding:.2em .6em;text-align:left}"
)


def markdown_page(score: Score, picture: str, diagram: str) -> str:
    """The page as Markdown; `picture` and `diagram` are where confusion matrix and reliability diagram will lie."""
    lines = ["# Blind check", "", _summary(score), ""]
    for title, note, (head, rows) in _sections(score):
        lines += [f"## {title}", "", note, ""]
        lines += [f"| {' | '.join(row)} |" for row in (head, ("---",) * len(head), *rows)] + [""]
    lines += ["## Confusion matrix", "", CONFUSION, "", f"![confusion matrix]({picture})", ""]
    return "\n".join([*lines, "## Reliability", "", RELIABILITY, "", f"![reliability diagram]({diagram})", ""])


def html_page(score: Score) -> str:
    """The page as one HTML file with the picture inside."""
    parts = [f"<h1>Blind check</h1><p>{escape(_summary(score))}</p>"]
    for title, note, (columns, rows) in _sections(score):
        cells = ["".join(f"<td>{escape(cell)}</td>" for cell in row) for row in rows]
        header = "".join(f"<th>{escape(cell)}</th>" for cell in columns)
        body = "".join(f"<tr>{row}</tr>" for row in cells)
        parts.append(f"<h2>{title}</h2><p>{escape(note)}</p><table><tr>{header}</tr>{body}</table>")
    parts.append(f"<h2>Confusion matrix</h2><p>{CONFUSION}</p>{confusion_svg(score.outcomes)}")
    parts.append(f"<h2>Reliability</h2><p>{RELIABILITY}</p>{reliability_svg(score.outcomes)}")
    head = f"<meta charset='utf-8'><title>Blind check</title><style>{STYLE}</style>"
    return f"<!doctype html><html><head>{head}</head><body>{''.join(parts)}</body></html>\n"


CONFUSION = (
    "Rows: what was sealed; columns: what the answer says. Blue is right, vermilion wrong; an effect that was "
    "withheld, or that the library does not hold, has its own row."
)
RELIABILITY = (
    "Over the probability that answers give to what they say, the share of them that is true, with 95 % intervals and "
    "the number of answers; on the dashed line probabilities mean what they say."
)


def _summary(score: Score) -> str:
    met = [figure.met for figure in score.figures if figure.met is not None]
    answered = sum(outcome.answer != "no answer" for outcome in score.outcomes)
    hashes = "; ".join(f"seal {seal}, seed {seed}" for seal, seed in zip(score.seals, score.seeds))
    return (
        f"{sum(met)} of {len(met)} goals are met on {len(score.outcomes)} cases, {answered} of them answered. "
        f"SHA-256: {hashes}."
    )


def _sections(score: Score) -> list[tuple[str, str, Table]]:
    misses = [o for o in score.outcomes if not (o.right and o.placed)]
    withheld = sorted((o for o in score.outcomes if o.kind == "withheld"), key=lambda o: o.truth)
    singles = [o for o in score.outcomes if o.kind == "single"]
    seen = sorted({o.truth for o in singles})
    return [
        ("Figures", "With 95 % intervals.", _figures(score)),
        (
            "Calibration of the intervals",
            "Of the sizes of effects that were named and placed, how many lie within the interval of each level, "
            "scaled from the 95 % that answers tell.",
            (("level", "holds", "95 % interval", "of"), [_held_row(score.outcomes, level) for level in LEVELS]),
        ),
        (
            "Calibration of the probabilities",
            "Of the answers whose probability lies in a range, how many are true.",
            (("probability", "mean", "true", "of"), _reliability_rows(score.outcomes)),
        ),
        (
            "Held-out closure",
            "Of what there was above the noise; withheld effects and strangers should close little.",
            (
                ("class", "cases", "smallest", "10 %", "median", "90 %", "largest"),
                [_closure_row(score.outcomes, *one) for one in CLOSED],
            ),
        ),
        (
            "Misses",
            f"{len(misses)} of {len(score.outcomes)}, with the reason; visibility is what an oracle sees of the "
            "effect, in deviations of the noise. The truth leaves: held-out gap that the sealed effects themselves "
            "leave; where it is 1 the search is to blame, where it is more the model.",
            (
                ("case", "class", "truth", "answer", "visibility", "closure", "truth leaves", "reason"),
                [
                    (
                        *(o.case, o.kind, o.truth, o.answer, f"{o.visibility:.1f}"),
                        *(_number(o.closure), _number(o.truth_leaves), o.reason),
                    )
                    for o in misses
                ],
            ),
        ),
        (
            "Withheld effects",
            "The diagnosis had to do without the effect that made the data; the suspect came closest instead, and "
            "closes what is told.",
            (
                ("effect", "answer", "right", "suspect", "closure", "where"),
                [(o.truth, o.answer, _yes(o.right), o.suspect, _number(o.closure), o.details) for o in withheld],
            ),
        ),
        (
            "Single effects",
            "How often each was named, and at its place; of those, medians and how many 95 % intervals hold.",
            (
                ("effect", "cases", "right id", "right place", "closure", "intervals hold", "time, s"),
                [_effect_row(name, [o for o in singles if o.truth == name]) for name in seen],
            ),
        ),
    ]


LEVELS = (0.5, 0.8, 0.9, 0.95, 0.99)
CLOSED = (
    ("solved", LISTED, True),
    ("not solved", LISTED, False),
    ("withheld or a stranger, right", ("withheld", "stranger"), True),
    ("withheld or a stranger, wrong", ("withheld", "stranger"), False),
)


def _figures(score: Score) -> Table:
    """All figures, and those of every set for itself."""
    numbers = range(1, len(score.apart) + 1) if len(score.apart) > 1 else ()
    head = ("figure", "value", "95 % interval", "of", "goal", "met", *(f"seed {number}" for number in numbers))
    rows = []
    for k, figure in enumerate(score.figures):
        value, interval = _measured(figure)
        told = (figure.name, value, interval, str(figure.count), _goal(figure.goal), _yes(figure.met))
        alone = [_measured(score.apart[number - 1].figures[k]) for number in numbers]
        rows.append((*told, *(f"{value} ({interval})" for value, interval in alone)))
    return head, rows


def _measured(figure: Figure) -> tuple[str, str]:
    return (f"{figure.value:.3g}", f"{figure.low:.3g} to {figure.high:.3g}") if figure.count else ("-", "-")


def _held_row(outcomes: Sequence[Outcome], level: float) -> tuple[str, ...]:
    inside = held(outcomes, level)
    low, high = wilson(sum(inside), len(inside))
    share = f"{sum(inside) / len(inside):.3g}" if inside else "-"
    return f"{level:g}", share, f"{low:.3g} to {high:.3g}", str(len(inside))


def _reliability_rows(outcomes: Sequence[Outcome]) -> list[tuple[str, ...]]:
    found = reliability(*given_and_true(outcomes))
    return [(f"{b.low:g} to {b.high:g}", f"{b.probability:.2f}", f"{b.true:.2f}", str(b.count)) for b in found]


def _closure_row(outcomes: Sequence[Outcome], name: str, kinds: Sequence[str], right: bool) -> tuple[str, ...]:
    closures = [o.closure for o in outcomes if o.kind in kinds and o.right == right and np.isfinite(o.closure)]
    shown = np.quantile(closures, (0, 0.1, 0.5, 0.9, 1)) if closures else np.full(5, np.nan)
    return name, str(len(closures)), *(_number(float(value)) for value in shown)


def _effect_row(name: str, own: Sequence[Outcome]) -> tuple[str, ...]:
    """What became of the cases of one effect."""
    right, inside = [o for o in own if o.right], held(own, 0.95)
    counts = (len(own), len(right), sum(o.placed for o in own))
    closure, time = (_median([getattr(o, what) for o in right]) for what in ("closure", "wall_s"))
    return name, *map(str, counts), closure, f"{sum(inside)} of {len(inside)}", time


def _median(values: Sequence[float]) -> str:
    return f"{np.median(values):.3g}" if values else "-"


def _goal(goal: tuple[float, float] | None) -> str:
    if goal is None:
        return ""
    low, high = goal
    if low == 0:
        return f"at most {high:g}"
    return f"at least {low:g}" if high >= 1 else f"{low:g} to {high:g}"


def _yes(answer: bool | None) -> str:
    return "" if answer is None else "yes" if answer else "no"


def _number(value: float) -> str:
    return f"{value:.2f}" if np.isfinite(value) else "-"
