"""Holding one answer against what was sealed, and saying why a miss is one.

single      right id: exactly the true effect is named; right place: at its location too
none        right: the verdict is "consistent"; anything else is a false alarm
clutter     as single
pair,       right: exactly the true effects are named
several
withheld,   right: "unexplained", or a tie that holds what the truth is known to be confused with;
stranger     a confident wrong name is a miss, and so is "consistent"

Where every machine has small effects besides (its clutter), naming one of those at its place, or what no recording
tells from it, is neither asked for nor wrong: such causes do not count, and an answer that names no other names none.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from boom_mj.blind.probabilities import given
from boom_mj.blind.unlisted import UNLISTED
from boom_mj.effects import builtin

ANGLES = ("phase", "direction")  # parameters that repeat after a turn
LISTED = ("single", "clutter", "pair", "several")  # classes whose effects are to be named
NO_ANSWER: Mapping[str, Any] = {"verdict": "no answer", "sentence": "", "effects": [], "ties": [], "gap": {}}


@dataclass(frozen=True)
class Outcome:
    """One case, graded.

    Attributes:
        case: its name.
        kind: single, none, pair, withheld, stranger, several or clutter.
        truth, answer: in a word or two, as rows and columns of the confusion matrix.
        right: whether the answer is right.
        placed: whether its places are right too.
        tied: whether the answer is a tie.
        held: whether the truth is in the answer at all, be it as one of a tie.
        errors: per parameter of rightly placed effects, true less named value; 1 is the end of its interval.
        closure: of the held-out gap; NaN without an answer.
        visibility: of the true effects to an oracle, in deviations of the noise.
        wall_s: time on one core: of the processor, or of the clock where the answer tells no other.
        reason: why a miss is one.
        suspect: what the answer took for its cause where it found no explanation, in a word or two.
        details: where it lies, by the answer.
        truth_leaves: held-out gap that the truth itself leaves; NaN where nobody asked (`oracle`).
        causes, named, hits: how many effects were sealed, are named, and are both, at the right place.
        probability: that the answer gives to what it says; NaN where it gives none.
        true: whether that is so (`probabilities`).
    """

    case: str
    kind: str
    truth: str
    answer: str
    right: bool
    placed: bool
    tied: bool
    held: bool
    errors: tuple[float, ...]
    closure: float
    visibility: float
    wall_s: float
    reason: str
    suspect: str
    details: str
    truth_leaves: float = np.nan
    causes: int = 0
    named: int = 0
    hits: int = 0
    probability: float = np.nan
    true: bool = False


def judge_case(case: str, truth: Mapping[str, Any], answer: Mapping[str, Any]) -> Outcome:
    """Hold an answer against what was sealed."""
    solved = answer["verdict"] in ("explained", "ambiguous", "partial")
    true, clutter = truth["effects"], [one for e in truth.get("clutter", ()) for one in (e, *e.get("alike", ()))]
    named = [e for e in answer["effects"] if _matching(e, true) or not _matching(e, clutter)] if solved else []
    ids, found = sorted(e["id"] for e in true), sorted(e["id"] for e in named)
    tied = _tied(answer)
    right = placed = held = False
    if truth["class"] == "none":
        allowed = ("consistent", "partial", "explained", "ambiguous", "unexplained") if clutter else ("consistent",)
        right = placed = held = answer["verdict"] in allowed and not named
    elif truth["class"] in LISTED:
        right = found == ids
        placed = right and all(_matching(effect, named) for effect in true)
        held = set(ids) <= {*found, *tied}
    else:
        unnamed = answer["verdict"] == "unexplained" or (solved and not named)
        right = placed = held = unnamed or (answer["verdict"] == "ambiguous" and bool(tied & twins(ids[0])))
    pairs = [(effect, _matching(effect, named)) for effect in true]
    hits = sum(other is not None for _, other in pairs)
    errors = [errors_of(effect["parameters"], other["parameters"]) for effect, other in pairs if other and right]
    return Outcome(
        case=case,
        kind=truth["class"],
        truth=" + ".join(ids) or "none",
        answer=" + ".join(found) if found else str(answer["verdict"]),
        right=right,
        placed=placed,
        tied=bool(tied),
        held=held,
        errors=tuple(error for one in errors for error in one),
        closure=_number(answer["gap"].get("closure")),
        visibility=truth["visibility"],
        wall_s=_number(answer.get("cpu_s", answer.get("wall_s"))),
        reason="" if right and placed else _reason(truth, answer, right),
        suspect="" if solved else _suspects(answer),
        details=(answer.get("remainder") or answer.get("unexplained") or {}).get("where") or answer["sentence"],
        causes=len(true),
        named=len(named),
        hits=hits,
        probability=given(answer),
        true=hits == len(named) if answer["verdict"] == "partial" else right and placed,
    )


def twins(name: str) -> set[str]:
    """Ids of the library that an effect is known to be confused with, from either side."""
    own = set({**builtin(), **UNLISTED}[name].confused_with)
    return (own | {k for k, kind in builtin().items() if name in kind.confused_with}) - {name}


def errors_of(true: Mapping[str, float], named: Mapping[str, Mapping[str, Any]]) -> list[float]:
    """True less named values, in units of the interval on that side of it; one without an end holds all."""
    errors = []
    for name, interval in named.items():
        if name in true:
            turns = np.round((interval["value"] - true[name]) / (2 * np.pi)) if name in ANGLES else 0.0
            error = true[name] + 2 * np.pi * turns - interval["value"]
            end = interval["high" if error > 0 else "low"]
            width = np.inf if end is None else abs(end - interval["value"])
            errors.append(float(error / width) if width else float(np.sign(error) * np.inf if error else 0.0))
    return errors


def _tied(answer: Mapping[str, Any]) -> set[str]:
    """Ids that an answer calls as good as its own."""
    return {e["id"] for tie in answer["ties"] for one in tie for e in (one, *one.get("with", ()))}


def _number(value: float | None) -> float:
    return np.nan if value is None else float(value)


def _matching(effect: Mapping[str, Any], named: Sequence[Mapping[str, Any]]) -> Mapping[str, Any] | None:
    same = [e for e in named if e["id"] == effect["id"] and e["location"] == effect["location"]]
    return same[0] if same else None


def _reason(truth: Mapping[str, Any], answer: Mapping[str, Any], right: bool) -> str:
    true, named = (" + ".join(_in_words(e) for e in effects) for effects in (truth["effects"], answer["effects"]))
    if answer["verdict"] == "no answer":
        return "there is no answer"
    if right:
        return f"right cause at the wrong place: {named} instead of {true}"
    if truth["class"] == "none":
        return f"false alarm: {named or answer['verdict']}"
    if answer["verdict"] == "consistent":
        return f"not seen: {true}, whose visibility is {truth['visibility']:.1f}"
    if answer["verdict"] == "unexplained":
        return f"not explained: {true}; suspected was {_suspects(answer) or 'nothing'}"
    tied = _tied(answer)
    beside = "; the truth is in the tie" if {e["id"] for e in truth["effects"]} & tied else ""
    return f"taken for {named}: {true}{beside}"


def _suspects(answer: Mapping[str, Any]) -> str:
    return " + ".join(_in_words(e) for e in answer["effects"] or answer.get("suspect", ()))


def _in_words(effect: Mapping[str, Any]) -> str:
    place = " ".join(f"{key} {value}" for key, value in effect["location"].items())
    return f"{effect['id']} {place}".strip()
