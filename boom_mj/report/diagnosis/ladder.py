"""The ladder of candidates: held-out gap of each, and why the rivals lost."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from boom_mj.diagnosis.scoring import Scored
from boom_mj.diagnosis.sentences import rival
from boom_mj.report.diagnosis.view import View
from boom_mj.report.drawing import gap_ticks
from boom_mj.report.section import Section
from boom_mj.report.words import effect_name, spoken

WIDTH, MARGIN = 300.0, 10.0  # px of the scale, and beside it
BEYOND = 30.0  # times the gap as built, where the scale ends
UNFITTED = 6  # candidates that screening sorted out and that are listed


@dataclass(frozen=True)
class Rung:
    """A candidate: gaps in training and held out, where they lie on the scale (px), and the verdict on it."""

    name: str
    role: str
    train: float
    held_out: float
    train_at: float
    held_out_at: float
    why: str


def section(view: View) -> Section:
    gaps = view.answer["gap"]
    sheet, built = ((_known(gaps["train"][at]), _known(gaps["holdout"][at])) for at in ("nominal", "before"))
    everything = [*sheet, *built, *(gap for j in view.found.scored for gap in (j.train, j.held_out))]
    highest = max([gap for gap in everything if np.isfinite(gap)], default=1.0)
    low, high = 0.8, max(4.0, min(1.15 * highest, BEYOND * float(np.nanmax([1.0, *built]))))
    at = _scale(low, high)

    def rung(name: str, role: str, train: float, held_out: float, why: str) -> Rung:
        return Rung(name, role, train, held_out, at(train), at(held_out), why)

    rungs = [
        rung("data sheet", "nominal", *sheet, "the file as it is"),
        rung("as built", "built", *built, "no causes, nuisances alone"),
    ]
    for judged in view.found.scored:
        own, tied = judged is view.found.best, judged in view.found.ties
        name = " + ".join(effect_name({"id": e.id, "location": e.location}) for e in judged.fit.effects)
        why = _own(view) if own else _why_not(view, judged, built)
        role = "best" if own else "tie" if tied else "rival"
        rungs.append(rung(name, role, judged.train, judged.held_out, why))
    ticks = [(tick, at(tick)) for tick in gap_ticks(low, high)]
    screened = [s for s in view.found.screened if s.candidate.places not in _fitted(view)][:UNFITTED]
    unfitted = [
        (effect_name({"id": e.id, "location": e.location}), s.share) for s in screened for e in s.candidate.effects
    ]
    facts = {"rungs": rungs, "ticks": ticks, "floor": at(1.0), "width": WIDTH, "unfitted": unfitted}
    return Section("ladder", "Which effect", facts)


def _own(view: View) -> str:
    match view.answer["verdict"]:
        case "unexplained":
            return "the best that there is, and not enough"
        case "ambiguous":
            return "the best, but not by more than chance"
    return "the explanation"


def _why_not(view: View, judged: Scored, built: tuple[float, float]) -> str:
    """Why a rival lost; what it closes only where it closes anything."""
    if not judged.held_out > built[1]:
        return spoken(rival(view.found, judged)["why_not"])
    if judged.train < built[0]:
        return "raises the held-out gap, though it lowers that in training"
    return "raises the gap"


def _fitted(view: View) -> set[tuple]:
    return {judged.fit.candidate.places for judged in view.found.scored}


def _known(gap: float | None) -> float:
    return np.nan if gap is None else gap


def _scale(low: float, high: float) -> Callable[[float], float]:
    """Place of a gap on a logarithmic scale, px; what is beyond lies at its end."""

    def at(gap: float) -> float:
        share = np.log(np.clip(np.nan_to_num(gap, nan=high), low, high) / low) / np.log(high / low)
        return float(MARGIN + share * (WIDTH - 2 * MARGIN))

    return at
