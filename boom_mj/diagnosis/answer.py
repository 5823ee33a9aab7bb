"""The answer as one document, and as a machine file with the effects in it."""

from collections.abc import Mapping, Sequence
from importlib.metadata import version
from typing import Any

import numpy as np

from boom_mj.diagnosis.candidate import Candidate
from boom_mj.diagnosis.diagnose import Diagnosis
from boom_mj.diagnosis.linearisation import of_size
from boom_mj.diagnosis.localisation import in_words, locate, looks
from boom_mj.diagnosis.scoring import Scored, gap
from boom_mj.effects import Effect
from boom_mj.machine import EffectEntry, Machine
from boom_mj.systems.predictor import Campaign

Array = np.ndarray
SURE = 1.96  # deviations of a 95 % interval
MOST = 0.5  # closure, its uncertainty taken off, from which causes are named that leave a gap
SHOWN = 0.002  # smallest share of a cell that is listed by itself


def document(found: Diagnosis, names: Sequence[str]) -> dict[str, Any]:
    """The answer in plain data: verdict, effects, rivals, ties, gaps, where, what is left.

    Of an "unexplained" gap `effects` are the causes that close most of it, if there are any; what closes less is listed
    as "suspect".
    """
    campaign, best = found.metric.campaign, found.best
    cells = locate(campaign, found.nominal)
    after = found.residual
    gaps = {
        part: {"before": gap(found.nominal, rows), "after": gap(after, rows), "floor": 1.0}
        for part, rows in (("train", campaign.train), ("holdout", campaign.held_out))
    }
    listed = [vars(cell) for cell in cells if cell.share >= SHOWN]
    rest = 1 - sum(cell["share"] for cell in listed)
    causes, certain = described(found) if best else [], found.solved or found.closure.low > MOST
    answer = {
        "verdict": found.verdict,
        "sentence": sentence(found),
        "effects": causes if certain else [],
        "suspect": [] if certain else causes,
        "rivals": [rival(found, other) for other in found.contest if other is not best][:8],
        "ties": [[_brief(j.fit.effects) for j in (best, *found.ties)]] if best and found.ties else [],
        "next_experiment": found.next_experiment,
        "gap": {
            **gaps,
            "closure": found.closure.value,
            "closure_interval": [found.closure.low, found.closure.high],
            "fidelity_alone": found.fidelity_alone,
            "split_in_time": campaign.split_in_time,
        },
        "where": [*listed, {"sensor": "all others", "share": rest}],
        "pushes": [vars(push) for push in found.pushes],
        "unexplained": None,
        "provenance": {
            "machine": campaign.subject.name,
            "recordings": {
                "train": list(names[: campaign.training]),
                "holdout": list(names[campaign.training :]),
                "learnt_in_part": [campaign.recordings[k].name for k in sorted(campaign.borrowed)],
            },
            **campaign.subject.provenance,
            "simulated_s": campaign.simulated_s,
            "boom_mj": version("boom_mj"),
            "mujoco": version("mujoco"),
        },
    }
    if found.verdict == "unexplained":
        left = gaps["holdout"]["after"] ** 2 - 1
        share = left / max(gaps["holdout"]["before"] ** 2 - 1, 1e-9)
        remaining = locate(campaign, after)
        answer["unexplained"] = {
            "share": float(np.clip(share, 0, 1)),
            "looks_like": looks(campaign, after),
            "where": in_words(remaining),
            "learn_from": [campaign.recordings[k].name for k in found.not_learnt],
        }
    return _plain(answer)


def described(found: Diagnosis) -> list[dict[str, Any]]:
    """The effects of the best explanation with sizes, intervals, and what each closes alone."""
    assert found.best is not None
    best = found.best
    knobs = best.fit.candidate.knobs
    entries = []
    for k, effect in enumerate(best.fit.effects):
        parameters = {}
        for number, (owner, name, knob) in enumerate(knobs):
            if owner == k:
                middle, reach = best.fit.coordinates[number], SURE * best.deviation[number]
                ends = sorted(knob.value(middle + side * reach) for side in (-1, 1))
                parameters[name] = {"value": effect.values[name], "low": ends[0], "high": ends[1], "unit": knob.unit}
        parameters |= _of_course(best, effect, parameters)
        alone = next((j for j in found.contest if j.fit.candidate.places == Candidate((effect,)).places), None)
        entries.append(
            {
                "id": effect.id,
                "location": effect.location,
                "parameters": parameters,
                "closure_alone": _closure(found, alone) if alone else None,
            }
        )
    return entries


def _of_course(best: Scored, effect: Effect, parameters: Mapping[str, Any]) -> dict[str, Any]:
    """What the course in time of an effect says of its parameters, if it has one."""
    courses = best.metric.courses
    if courses is None or not courses.parts:
        return {}
    ends = [{**effect.values, **{name: told[end] for name, told in parameters.items()}} for end in ("low", "high")]
    found = [type(effect)(effect.location, **values).course(s) for values in ends for s in courses.reach]
    return {
        name: {
            "value": value,
            "low": min(one[name] for one in found),
            "high": max(one[name] for one in found),
            "unit": effect.parameters[name].unit,
        }
        for name, value in effect.course(courses.strength).items()
    }


def rival(found: Diagnosis, other: Scored) -> dict[str, Any]:
    """A candidate that lost, and why."""
    share = _closure(found, other)
    why = f"closes {share:.0%} of the held-out gap" if share > -1 else "fits no better at any size"
    if found.best:
        if other in found.ties:
            why += ": within the uncertainty of the best"
        elif set(found.best.fit.candidate.places) < set(other.fit.candidate.places):
            why += f": no better than {found.best.label} alone"
        elif other.held_out > found.best.held_out:
            why += f", {found.best.label} {_closure(found, found.best):.0%}"
    if share > -1 and other.held_out > 1.1 * other.train:
        why += (
            f"; it fits the training data better ({other.train:.2f}) than what it has not seen ({other.held_out:.2f})"
        )
    return {**_brief(other.fit.effects), "holdout_gap": other.held_out, "why_not": why}


def sentence(found: Diagnosis) -> str:
    """The verdict in words."""
    campaign = found.metric.campaign
    before = gap(found.nominal, campaign.held_out)
    if found.verdict == "consistent":
        return f"No gap beyond noise and model error: {before:.2f} on what was held out, 1 is the floor."
    where = in_words(locate(campaign, found.nominal))
    if found.verdict == "unexplained":
        leaves = f"close {found.closure.value:.0%} and leave {found.best.held_out:.1f}" if found.best else ""
        tried = f"; {found.best.label} would {leaves}" if found.best else ""
        hidden = " and ".join(campaign.recordings[k].name for k in found.not_learnt)
        advice = f" What was learnt from does not show all of it; learn from {hidden} as well." if hidden else ""
        return f"The gap of {before:.1f} has no explanation in the library{tried}: {where}.{advice}"
    causes = [_in_words(entry) for entry in described(found)]
    cause, close = " and ".join(causes), "closes" if len(causes) == 1 else "close"
    text = f"{cause[0].upper()}{cause[1:]} {close} {found.closure.value:.0%} of the held-out gap of {before:.1f}"
    if found.ties:
        text += ", and so would " + " or ".join(j.label for j in found.ties)
        if found.next_experiment:
            text += f"; {found.next_experiment} would tell them apart"
    return f"{text}. Without it, {where}.{_borrowed(campaign)}"


def _borrowed(campaign: Campaign) -> str:
    """What was learnt from beyond the recordings for it."""
    names = " and ".join(campaign.recordings[k].name for k in sorted(campaign.borrowed))
    words = campaign.subject.words
    return f" Recordings to learn from do not show it: {words.learnt} of {names} taught it as well." if names else ""


def with_effects_text(machine_text: str, found: Diagnosis) -> str:
    """A machine file's text with the effects of the best explanation and the tolerances that were estimated."""
    return machine_text.rstrip("\n") + "\n" + "".join(f"\n{_toml(entry)}" for entry in _entries(found))


def with_effects(machine: Machine, found: Diagnosis) -> Machine:
    """A machine as `with_effects_text` would write it."""
    added = (EffectEntry.model_validate(entry) for entry in _entries(found))
    return machine.model_copy(update={"effect": (*machine.effect, *added)})


def estimated_tolerances(found: Diagnosis) -> tuple[Effect, ...]:
    """Nuisances as effects of the size that the diagnosis estimated, zero offsets first; none of the named causes."""
    metric = found.best.metric if found.best else found.metric
    effects = found.best.fit.effects if found.best else ()
    estimate = metric.estimate(metric.residual(*metric.predict([effects])))
    return of_size([t.beside(effects) for t in metric.nuisances], estimate)


def twins(found: Diagnosis, corrected: bool) -> list[dict[str, Array]]:
    """What every recording's sensors would have said, by signal, at its own times, (n, k) each.

    Args:
        corrected: of the best explanation, or of the nominal machine; both have the tolerances that were estimated.
    """
    campaign = found.metric.campaign
    effects = (*estimated_tolerances(found), *(found.best.fit.effects if corrected and found.best else ()))
    level = campaign.subject.fidelity.shown
    return [campaign.twin(effects, level, index) for index in range(len(campaign.recordings))]


def _entries(found: Diagnosis) -> list[dict[str, Any]]:
    """What a machine file would say of the effects that were found: ids, places, and what is not neutral."""
    effects = (*estimated_tolerances(found), *(found.best.fit.effects if found.best else ()))
    return [
        {"id": e.id, **e.location, **{k: v for k, v in e.values.items() if v != e.parameters[k].neutral}}
        for e in effects
    ]


def _toml(entry: Mapping[str, Any]) -> str:
    return "\n".join(["[[effect]]", *(f"{k} = {v!r}".replace("'", '"') for k, v in entry.items())]) + "\n"


def _in_words(entry: Mapping[str, Any]) -> str:
    """An effect as `described`."""
    place = ", ".join(f"{k} {v}" for k, v in entry["location"].items())
    told = entry["parameters"].items()
    sizes = ", ".join(f"{name} {size['value']:.4g} {size['unit']}".removesuffix(" 1") for name, size in told)
    return f"{entry['id'].replace('_', ' ')}{f' at {place}' if place else ''} ({sizes})"


def _brief(effects: Sequence[Effect]) -> dict[str, Any]:
    """An explanation by name: its first effect, and the others beside it."""
    first, *others = ({"id": effect.id, "location": effect.location} for effect in effects)
    return {**first, "with": others} if others else first


def _closure(found: Diagnosis, judged: Scored) -> float:
    before = gap(found.nominal, found.metric.campaign.held_out)
    return (before - judged.held_out) / max(before - 1, 1e-9)


def _plain(value: Any) -> Any:
    """Numbers that JSON can hold: infinities and NaN as null."""
    if isinstance(value, dict):
        return {key: _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if isinstance(value, float | np.floating):
        return float(value) if np.isfinite(value) else None
    return value.item() if isinstance(value, np.generic) else value
