"""The verdict in words, the figures that carry it, and the effects with their sizes."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from boom_mj.diagnosis import estimated_nuisances
from boom_mj.effects import behind
from boom_mj.report.diagnosis.view import View
from boom_mj.report.section import Section
from boom_mj.report.words import (
    MINUS,
    SPACE,
    capital,
    digits_of,
    effect_name,
    explanation_name,
    gap_size,
    number,
    percent,
    physics,
    spoken,
)

NEXT = {
    "consistent": "Nothing: the machine does what the simulation says.",
    "explained": "Look at the machine where the effect lies, and simulate with the file of gap diagnose -o FILE.",
    "ambiguous": "Record an experiment that tells the explanations apart, and diagnose with it.",
    "partial": "Look at the machine where the effects lie, then at what is left, below.",
    "unexplained": "See where it lies and what is left, below; gap discover looks for a law that no library has.",
}
LEFT_OUT = "Look at the sensor that was left out, its mount and plug; if it is sound, at what acts on it alone."
NOTHING_SURE = "No cause is sure"
SURE = "What the machine has and the nominal model lacks"
SURE_IN_PART = "Causes that are sure, though something is left"
SUSPECTS = "The best suspect, which does not explain enough or may be nothing"
SUSPECTS_BESIDE = "Suspects: what else helps, though others may do the same"
RIGHT = {
    "consistent": "that nothing is wrong, what these recordings do not show included",
    "explained": "that this is all there is, what these recordings do not show included",
    "ambiguous": "that the first is all there is, what these recordings do not show included",
    "partial": "that these effects are there",
    "unexplained": "that something is at work that the library does not hold",
}


def section(view: View) -> Section:
    answer = view.answer
    return Section(
        "verdict",
        NOTHING_SURE if view.found.closed_by_little else headline(answer),
        {
            "verdict": answer["verdict"],
            "sentence": spoken(answer["sentence"]),
            "figures": figures(view),
            "tables": tables(answer),
            "physics": {effect.id: physics(effect) for effect in view.effects},
            "ties": [explanation_name(tie) for tie in _ties(view)],
            "next_experiment": answer["next_experiment"],
            "next": LEFT_OUT if answer["with_outliers"] else NEXT[answer["verdict"]],
            "zero_offsets": offsets(view),
            "data": [row["finding"] for row in answer["data"]],
        },
    )


def tables(answer: Mapping[str, Any]) -> list[tuple[str, list[dict[str, str]]]]:
    """Caption and rows of the causes that are sure, and of suspects."""
    sure, suspects = ([row for effect in answer[kind] for row in rows(effect)] for kind in ("effects", "suspect"))
    said = SURE_IN_PART if answer["verdict"] == "partial" else SURE
    beside = SUSPECTS_BESIDE if sure else SUSPECTS
    return [(caption, own) for caption, own in ((said, sure), (beside, suspects)) if own]


def headline(answer: Mapping[str, Any]) -> str:
    """The verdict in a few words."""
    names = " and ".join(effect_name(effect) for effect in answer["effects"])
    match answer["verdict"]:
        case "consistent":
            return "Simulator and machine agree"
        case "unexplained":
            return NOTHING_SURE if answer["ties"] else "No effect of the library explains the gap"
        case "ambiguous":
            others = ", or ".join(explanation_name(tie) for tie in answer["ties"][0][1:])
            return f"{capital(names)}, or {others}"
    if answer["verdict"] == "partial":
        return f"{capital(names)}, and something else"
    several, beside = len(answer["effects"]) > 1, " and what is beside" if answer["suspect"] else ""
    return f"{capital(names)}{beside} {'explain' if several or beside else 'explains'} the gap"


def figures(view: View) -> list[tuple[str, str, str]]:
    """Figure, what it is, what it means."""
    gap = view.answer["gap"]
    found = [
        (
            "Gap held out",
            _fall(gap["holdout"], view.corrected),
            f"data sheet, as built{', with causes' if view.corrected else ''}; in units of noise, 1 is the floor",
        ),
        ("Gap in training", _fall(gap["train"], view.corrected), "the recordings that the fit has seen"),
    ]
    right = RIGHT[view.answer["verdict"]] + ", or a little of much" * view.found.closed_by_little
    found.append(("Probability", percent(view.answer["probability"]), right))
    if view.corrected and gap["closure"] is not None and gap["holdout"]["before"] > 1:
        low, high = gap["closure_interval"]
        span = "" if low is None or high is None else f"95 % interval {percent(low)} to {percent(high)}"
        found.append(("Closed, held out", percent(gap["closure"]), span))
    if gap["fidelity_alone"] is not None:
        meaning = f"of the coarse model's gap, by {view.facts.wording.finer} alone"
        found.append(("Finer model closes", percent(gap["fidelity_alone"]), meaning))
    return found


def rows(effect: Mapping[str, Any]) -> list[dict[str, str]]:
    """One row per parameter of an effect."""
    alone = effect["closure_alone"]
    return [
        {
            "id": effect["id"],
            "effect": effect_name(effect),
            "parameter": name,
            "value": number(p["value"], digits := digits_of(p["low"], p["high"])),
            "interval": f"{number(p['low'], digits)} to {number(p['high'], digits)}",
            "unit": behind(p["unit"]).lstrip(),
            "alone": "" if alone is None else percent(alone),
            "probability": percent(effect["probability"]),
        }
        for name, p in effect["parameters"].items()
    ]


def offsets(view: View) -> list[str]:
    """Zero offsets of sensors that were estimated along, of angles in degrees."""
    found = []
    for effect in estimated_nuisances(view.found):
        for name, value in effect.values.items() if effect.id == view.facts.wording.zero_offset else ():
            unit = effect.declared[name].unit
            size = f"{np.degrees(value):+.2f}°" if unit == "rad" else f"{value:+.2g}{behind(unit)}"
            place = " and ".join(f"{k}{SPACE}{v}" for k, v in effect.location.items())
            place = place or name.replace("joint", f"joint{SPACE}")
            found.append(f"{place} {size.replace('-', MINUS)}")
    return found


def _ties(view: View) -> list[Any]:
    return view.answer["ties"][0] if view.answer["ties"] else []


def _fall(gaps: Mapping[str, float | None], corrected: bool) -> str:
    steps = ("nominal", "before", "after") if corrected else ("nominal", "before")
    before = gaps["before"]
    within = corrected and before is not None and before <= 1
    sizes = [f"{gaps[step]:.3f}" if within and step != "nominal" else gap_size(gaps[step]) for step in steps]
    return " → ".join(sizes)
