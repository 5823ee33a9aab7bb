"""The answer of a discovery as one document of plain data."""

from collections.abc import Sequence
from importlib.metadata import version
from typing import Any

from boom_mj.diagnosis.answer import plain
from boom_mj.diagnosis.named import brief
from boom_mj.diagnosis.scoring import held_out_closure
from boom_mj.discovery.discover import Discovery
from boom_mj.discovery.forces import ForceInTime
from boom_mj.discovery.search import FoundLaw
from boom_mj.discovery.writing import intervals, law_type, with_numbers
from boom_mj.estimation.bootstrap import gap
from boom_mj.replay.quality import DataFinding


def document(found: Discovery, names: Sequence[str], findings: Sequence[DataFinding] = ()) -> dict[str, Any]:
    """Verdict, law, gaps, the front of laws by length, and what the library does."""
    data, best = found.model.data, found.best
    after = best.residual if best else found.as_built
    gaps = {
        part: {"before": gap(found.as_built, rows), "after": gap(after, rows), "floor": 1.0}
        for part, rows in (("train", data.train), ("holdout", data.held_out))
    }
    share = found.closure
    law = {**_law(best), "same_as": _effect(found.same_as)} if best and found.verdict == "law" else None
    answer = {
        "verdict": found.verdict,
        "sentence": sentence(found),
        "law": law,
        "gap": {**gaps, "closure": share.value, "closure_interval": [share.low, share.high]},
        "front": [_row(one) for one in found.front],
        "ties": [_row(one) for one in found.ties],
        "places": [
            {"place": one.place.named, "acts_on": one.place.acts_on, "closure": _closure(found, one)}
            for one in found.places
        ],
        "forces": [_force(found, one, best=one is found.forces[0]) for one in found.forces],
        "library": None
        if found.library is None
        else {**brief(found.library.fit.effects), "holdout_gap": found.library.held_out},
        "withheld": _effect(found.withheld),
        "data": [finding.document() for finding in findings],
        "complete": not found.skipped,
        "skipped": list(found.skipped),
        "provenance": {
            "machine": found.model.facts.name,
            "recordings": {"train": list(names[: data.training]), "holdout": list(names[data.training :])},
            "simulated_s": found.model.predictor.simulated_s,
            "boom_mj": version("boom_mj"),
            "mujoco": version("mujoco"),
        },
    }
    return plain(answer)


def _closure(found: Discovery, law: FoundLaw) -> float:
    """Of the held-out gap."""
    return held_out_closure(found.model, found.as_built, law.residual).value


def _law(law: FoundLaw) -> dict[str, Any]:
    effect = law.scored.fit.effects[0]
    parameters = {
        name: {"value": value, "low": low, "high": high, "unit": effect.declared[name].unit}
        for name, (value, low, high) in intervals(law).items()
    }
    return {
        "place": law.place.named,
        "acts_on": law.place.acts_on,
        "formula": law_type(law).formula,
        "terms": [term.name for term in law.terms],
        "parameters": parameters,
    }


def _row(law: FoundLaw) -> dict[str, Any]:
    return {
        "formula": with_numbers(law),
        "place": law.place.named,
        "acts_on": law.place.acts_on,
        "terms": [term.name for term in law.terms],
        "holdout_gap": law.held_out,
    }


def _force(found: Discovery, one: ForceInTime, best: bool) -> dict[str, Any]:
    """With its time history where it is the best."""
    names = [log.name for log in found.model.data.recordings]
    histories = [
        {
            "recording": names[k],
            "time": time.tolist(),
            **{
                way: {"value": mean.tolist(), "deviation": deviation.tolist()}
                for way, (mean, deviation) in zip(one.place.pushes, one.force[k])
            },
        }
        for k, time in one.time.items()
    ]
    return {
        "acts_on": one.place.acts_on,
        "unit": one.place.unit,
        "closure": one.closure.value,
        "closure_interval": [one.closure.low, one.closure.high],
        "histories": histories if best else [],
    }


def _effect(scored: Any) -> str | None:
    return scored.fit.effects[0].id if scored else None


def sentence(found: Discovery) -> str:
    """What was found, in words."""
    data, best, share = found.model.data, found.best, found.closure
    size = gap(found.as_built, data.held_out)
    if best is None and found.skipped:
        return f"There was no time to fit a law to a held-out gap of {size:.2f}."
    if best is None and not found.healthy:
        return f"There is no place whose law could close most of the held-out gap of {size:.2f}.{_instead(found)}"
    if best is None:
        return f"There is nothing to discover: the held-out gap is {size:.2f}, where noise alone leaves 1."
    law = f"{with_numbers(best)}, on {best.place.acts_on}"
    if found.verdict == "law":
        known = ""
        if found.same_as:
            known = f" The library has it: it is {found.same_as.label}."
        elif found.withheld:
            known = f" It is not new: {found.withheld.label} of the library, left out here, leaves less."
        count = len(found.ties)
        also = "" if not count else " Another law does as well." if count == 1 else f" {count} other laws do as well."
        return f"The law is {law}: it closes {share.value:.0%} of the held-out gap.{known}{also}"
    if found.library is not None and found.library.held_out < best.held_out:
        return (
            f"No law: the library's {found.library.label} leaves less (a held-out gap of {found.library.held_out:.2f}) "
            f"than the best law of this grammar ({best.held_out:.2f}); ask gap diagnose.{_instead(found)}"
        )
    return (
        "No law of this grammar surely closes more than half of the gap; "
        f"the best, {law}, closes {share.value:.0%}.{_instead(found)}"
    )


def _instead(found: Discovery) -> str:
    """What a force without a formula does where no law does."""
    best = next(iter(found.forces), None)
    if best is None or best.closure.low <= found.model.criteria.main_share:
        return ""
    return f" A force in time on {best.place.acts_on}, without a formula, closes {best.closure.value:.0%}."
