"""Explanations in plain data: effects with sizes, intervals and what each closes alone."""

from collections.abc import Mapping, Sequence
from typing import Any

from boom_mj.diagnosis.budget import inclusion
from boom_mj.diagnosis.candidate import Candidate
from boom_mj.diagnosis.conclusion import Diagnosis
from boom_mj.diagnosis.scoring import Scored
from boom_mj.effects import Effect
from boom_mj.estimation.bootstrap import gap
from boom_mj.estimation.intervals import Z95


def described(found: Diagnosis) -> list[dict[str, Any]]:
    """The effects of the best explanation with sizes, intervals, and what each closes alone."""
    assert found.best is not None
    best = found.best
    entries = []
    for k, (effect, entry) in enumerate(zip(best.fit.effects, located(best))):
        alone = next((j for j in found.scored if j.fit.candidate.places == Candidate((effect,)).places), None)
        entries.append(
            {
                **entry,
                "closure_alone": closure_of(found, alone) if alone else None,
                **_share(found, k),
                "probability": probability(found, effect),
            }
        )
    return entries


def located(scored: Scored) -> list[dict[str, Any]]:
    """Effects of an explanation with their places, sizes and intervals."""
    entries = []
    for k, effect in enumerate(scored.fit.effects):
        parameters = _sizes(scored, k)
        parameters |= _of_latent(scored, effect, parameters)
        entries.append({"id": effect.id, "location": effect.location, "parameters": parameters})
    return entries


def _sizes(scored: Scored, number: int) -> dict[str, Any]:
    """Of one effect of an explanation, with their intervals."""
    sizes = {}
    for k, (owner, name, parameter) in enumerate(scored.fit.candidate.parameters):
        if owner == number:
            value, low, high = interval_of(scored, k)
            sizes[name] = {"value": value, "low": low, "high": high, "unit": parameter.unit}
            if not parameter.plausible(value):
                sizes[name]["implausible"] = True
    return sizes


def interval_of(scored: Scored, number: int) -> tuple[float, float, float]:
    """A parameter's value, and the ends of its 95 % interval."""
    owner, name, parameter = scored.fit.candidate.parameters[number]
    middle, reach = scored.fit.scaled[number], Z95 * scored.deviation[number]
    low, high = sorted(parameter.value(middle + side * reach) for side in (-1, 1))
    return scored.fit.effects[owner].values[name], low, high


def _of_latent(best: Scored, effect: Effect, parameters: Mapping[str, Any]) -> dict[str, Any]:
    """What the latent input of an effect says of its parameters, if it has one."""
    latent = best.model.latent
    if latent is None or not latent.parts:
        return {}
    ends = [{**effect.values, **{name: size[end] for name, size in parameters.items()}} for end in ("low", "high")]
    found = [type(effect)(effect.site, **values).with_latent(s) for values in ends for s in latent.interval]
    return {
        name: {
            "value": value,
            "low": min(one[name] for one in found),
            "high": max(one[name] for one in found),
            "unit": effect.declared[name].unit,
        }
        for name, value in effect.with_latent(latent.strength).items()
    }


def _share(found: Diagnosis, number: int) -> dict[str, Any]:
    """What an effect of the best explanation takes of the held-out gap."""
    assert found.budget is not None
    share = found.budget.shares[number]
    return {"share": share.value, "share_interval": [share.low, share.high]}


def probability(found: Diagnosis, effect: Effect) -> float:
    """That the machine has an effect of the best explanation, whatever else it has.

    Of one whose sizes may be nothing it is less by the level at which they are not (`Scored.level`).
    """
    assert found.best is not None
    if found.verdict == "partial" and not found.outliers and found.sure[found.best.fit.effects.index(effect)]:
        return 1 - found.criteria.shadow
    nothing = found.criteria.unnamed and not found.best.shows(effect)
    return inclusion(found.odds, found.scored, effect) * (found.best.level(effect) if nothing else 1.0)


def probability_of_all(found: Diagnosis) -> float:
    """That an answer is right as a whole: these causes are all, or those that are sure are there, or there is none.

    An unexplained gap is right where something outside the library is at work, or a little of much in it.
    """
    odds = found.odds
    if found.verdict == "unexplained":
        return odds.outside_library + found.closed_by_little * sum(odds.explanations)
    if found.best is None:
        return odds.none * (1 - odds.unwell)
    named = [probability(found, e) for e, so in zip(found.best.fit.effects, found.named) if so]
    return min(named) * (1.0 if found.verdict == "partial" else 1 - odds.hidden)


def closure_of(found: Diagnosis, scored: Scored) -> float:
    """Of one candidate, on held-out entries."""
    before = gap(found.as_built, found.model.data.held_out)
    least = found.best.held_out if found.best else 1.0
    return (before - scored.held_out) / max(before - min(least, 1.0), 1e-9)


def brief(effects: Sequence[Effect]) -> dict[str, Any]:
    """An explanation by name: its first effect, and the others beside it."""
    return _together([{"id": effect.id, "location": effect.location} for effect in effects])


def sized(scored: Scored) -> dict[str, Any]:
    """The same with sizes."""
    effects = enumerate(scored.fit.effects)
    return _together([{"id": e.id, "location": e.location, "parameters": _sizes(scored, k)} for k, e in effects])


def _together(effects: Sequence[dict[str, Any]]) -> dict[str, Any]:
    first, *others = effects
    return {**first, "with": others} if others else first
