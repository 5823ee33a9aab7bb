"""The answer in words."""

from collections.abc import Mapping
from typing import Any

from boom_mj.diagnosis.candidate import Candidate
from boom_mj.diagnosis.conclusion import Diagnosis
from boom_mj.diagnosis.localisation import in_words, locate
from boom_mj.diagnosis.named import brief, closure_of, described
from boom_mj.diagnosis.scoring import Scored
from boom_mj.effects import behind
from boom_mj.effects.free_resistance import FreeResistance
from boom_mj.estimation.bootstrap import gap

BESIDE = 4  # suspects that a sentence names


def rival(found: Diagnosis, other: Scored) -> dict[str, Any]:
    """A candidate that lost, and why."""
    share, probability = closure_of(found, other), found.odds.explanations[found.scored.index(other)]
    why = f"closes {share:.0%} of the held-out gap" if share > -1 else "fits no better at any size"
    if found.best:
        if other in found.ties:
            why += ": within the uncertainty of the best"
        elif set(found.best.fit.candidate.places) < set(other.fit.candidate.places):
            why += f": no better than {found.best.label} alone"
        elif other.held_out > found.best.held_out:
            why += f", {found.best.label} {closure_of(found, found.best):.0%}"
    if share > -1 and other.held_out > 1.1 * other.train:
        why += (
            f"; it fits the training data better ({other.train:.2f}) than what it has not seen ({other.held_out:.2f})"
        )
    return {**brief(other.fit.effects), "holdout_gap": other.held_out, "why_not": why, "probability": probability}


def sentence(found: Diagnosis) -> str:
    """The verdict in words."""
    data = found.model.data
    before = gap(found.as_built, data.held_out)
    if found.verdict == "consistent":
        return f"No gap beyond noise and model error: {before:.2f} on what was held out, 1 is the floor."
    where = in_words(locate(found.model, found.as_built))
    if found.outliers and found.verdict == "unexplained":
        likely = " or ".join(one.label for one in (found.best, *found.ties) if one)
        none = f"no gap is left beyond noise and model error: {before:.2f}, 1 is the floor"
        rest = f"it is {before:.1f}, which {likely} would explain; no cause is sure" if likely else none
        return f"{_but_for(found)}. Without, {rest}."
    if found.verdict == "unexplained":
        leaves = f"close {found.closure.value:.0%} and leave {found.best.held_out:.1f}" if found.best else ""
        tried = f"; {found.best.label} would {leaves}" if found.best else ""
        hidden = " and ".join(data.recordings[k].name for k in found.not_trained)
        advice = f" Training recordings do not show all of it; train with {hidden} as well." if hidden else ""
        advice += _other_laws(found) + _simulated(found) + _unfinished(found)
        if found.best and found.closed_by_little:
            little = f"{found.best.label} would {leaves}, but a little of other effects may do what each of its does"
            return f"No cause of the gap of {before:.1f} is sure: {little}. {where[0].upper()}{where[1:]}.{advice}"
        return f"The gap of {before:.1f} has no explanation in the library{tried}: {where}.{advice}"
    causes = [_in_words(entry) for entry, so in zip(described(found), found.named) if so]
    cause, close = " and ".join(causes), "closes" if len(causes) == 1 else "close"
    together = "" if all(found.named) else ", with what acts beside,"
    whole = f"{close} {found.closure.value:.0%} of the held-out gap of {before:.1f}"
    if before <= found.criteria.healthy_gap:
        after, show = gap(found.residual, data.held_out), close.replace("close", "show")
        whole = f"{show} within noise: {before:.3f} without and {after:.3f} with it on what was held out"
    text = f"{cause[0].upper()}{cause[1:]}{together} {whole}"
    if found.ties and found.verdict != "partial":
        rivals = (j.label + ", of implausible size" * (not j.plausible) for j in found.ties)
        text += ", and so would " + " or ".join(rivals)
        if found.next_experiment:
            text += f"; {found.next_experiment} would tell them apart"
    if found.outliers:
        text += f" that is left without {' and '.join(part.name for part in found.outliers)}. {_but_for(found)}"
    elif found.verdict == "partial":
        left = f"{found.best.held_out:.2f} is left" if found.best else ""
        text += f"; {left}, which {in_words(locate(found.model, found.residual)).replace('it is seen', 'is seen')}"
    if found.criteria.gain_z and not found.outliers and (beside := _beside(found)):
        others = f" and {len(beside) - BESIDE} others" * (len(beside) > BESIDE)
        text += f". The data do not tell what acts beside: {', '.join(beside[:BESIDE])}{others}"
    if before > found.criteria.healthy_gap:
        text += f". Without it, {where}"
    return f"{text}.{_extended(found)}{_other_laws(found)}{_simulated(found)}{_unfinished(found)}"


def _but_for(found: Diagnosis) -> str:
    """What was left out, and what was found with it."""
    names, whole = " and ".join(part.name for part in found.outliers), found.with_outliers
    least = min(part.gap for part in found.outliers)
    before = gap(whole.as_built, whole.model.data.held_out) if whole else float("nan")
    left = f", of which {whole.best.label} leaves {whole.best.held_out:.1f}" if whole and whole.best else ""
    return (
        f"Nothing in the library explains {names}, at least {least:.1f} times the noise off: left out. "
        f"With that the held-out gap is {before:.1f}{left}"
    )


def _beside(found: Diagnosis) -> list[str]:
    """Causes that are not sure, of the best explanation and, where that leaves something, of those that do as well."""
    explanations = [one.fit.effects for one in (found.best, *(found.ties if found.verdict == "partial" else ())) if one]
    sure = {e.cause for e, so in zip(found.best.fit.effects, found.named) if so} if found.best else set()
    beside = [effect for effects in explanations for effect in effects if effect.cause not in sure]
    return list(dict.fromkeys(Candidate((effect,)).label.replace("_", " ") for effect in beside))


def other_laws(found: Diagnosis) -> list[tuple[dict[str, int | str], float]]:
    """Places at which a cause only stands in for another law, and the gap that any function of speed leaves there."""
    free = ((effect, one) for one in found.freed for effect in one.fit.effects if isinstance(effect, FreeResistance))
    return [(effect.location, one.held_out) for effect, one in free]


def _other_laws(found: Diagnosis) -> str:
    joints = " and ".join(f"joint {place['joint']} ({left:.1f} is left)" for place, left in other_laws(found))
    return f" Another law resists {joints}, if it may be any function of speed: ask gap discover." if joints else ""


def _simulated(found: Diagnosis) -> str:
    """That recordings look like those of the simplest model, where it leaves a gap near noise."""
    if found.simplest is None or found.simplest > found.criteria.near_noise_gap:
        return ""
    simplest = found.model.facts.wording.simplest
    return f" A model of {simplest} leaves {found.simplest:.2f}: the recordings look as if it had made them."


def _unfinished(found: Diagnosis) -> str:
    """What was not looked at."""
    return f" For want of time {len(found.skipped)} steps of the search were left out." if found.skipped else ""


def _extended(found: Diagnosis) -> str:
    """What trained beyond the recordings for it."""
    data = found.model.data
    names = " and ".join(data.recordings[k].name for k in sorted(data.extended))
    part = found.model.facts.wording.first_part
    return f" Training recordings do not show it: {part} of {names} trained as well." if names else ""


def _in_words(entry: Mapping[str, Any]) -> str:
    """An effect as `described`."""
    place = ", ".join(f"{k} {v}" for k, v in entry["location"].items())
    sizes = ", ".join(
        f"{name} {size['value']:.4g}{behind(size['unit'])}" + ", implausible" * ("implausible" in size)
        for name, size in entry["parameters"].items()
    )
    return f"{entry['id'].replace('_', ' ')}{f' at {place}' if place else ''} ({sizes})"
