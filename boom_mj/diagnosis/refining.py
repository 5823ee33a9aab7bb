"""Refining a fit about the machine that it makes, and beginning it anew where it stays at a wrong size."""

from collections.abc import Iterator

import numpy as np

from boom_mj.diagnosis.candidate import Candidate
from boom_mj.diagnosis.clock import Clock
from boom_mj.diagnosis.decision import Gaps, solved
from boom_mj.diagnosis.fitting import fit, grid_starts, refine_jointly
from boom_mj.diagnosis.linearisation import Linearisation
from boom_mj.diagnosis.scoring import Scored, alternatives, profiled, score
from boom_mj.effects import Effect, Values
from boom_mj.estimation.bootstrap import gap
from boom_mj.estimation.least_squares import OPTIONS


def near(model: Linearisation, before: float) -> float:
    """Up to where most of a gap is gone."""
    return max(model.criteria.near_noise_gap, 1 + model.budget.far * (before - 1))


def refine(scored: Scored, as_built: Gaps, clock: Clock) -> Scored:
    """Fit again from where the last fit has led, then with the nuisances and model error there, until it stays."""
    budget, oscillatory = scored.model.budget, scored.model.facts.oscillatory
    for number in range(1 + budget.rounds):
        if clock.over(f"refinement {number + 1} of {scored.label}"):
            break
        model, effects = scored.model, scored.fit.effects
        estimate = model.posterior.estimate(model.residual(*model.predict([effects])))
        model = model.relinearised(effects, estimate) if number else model.rebased(effects, estimate)
        if number and oscillatory:
            again = score(*refine_jointly(model, Candidate(effects)))
        else:
            again = score(model, fit(model, Candidate(effects), OPTIONS.rough if oscillatory else OPTIONS.sharp))
        if again.train > budget.worse * scored.train:
            break
        moved, helped = np.abs(again.fit.scaled - scored.fit.scaled), again.train < budget.helped * scored.train
        scored, stays = again, number and np.all(moved < np.maximum(budget.still, again.deviation))
        hopeless = oscillatory and not helped and again.train > near(model, as_built[0])
        if hopeless or (stays and not (helped and max(again.gaps) > model.criteria.explained_gap)):
            break
    if oscillatory and scored.train < near(scored.model, as_built[0]):
        scored = beyond(scored)
    return profiled(scored, as_built[0])


def beyond(found: Scored) -> Scored:
    """Fitted from where one size of what does not grow with it leaves less, if any does.

    Beyond a threshold, where nothing slips, a size changes nothing more, and no derivative on this side tells of it.
    """
    model, effects, train = found.model, found.fit.effects, found.model.data.train
    others = [_with(effects, k, {name: size}) for k, point in _unscaled(effects) for name, size in point.items()]
    seen = model.predict(others, training_only=True) if others else []
    left = np.nan_to_num([gap(model.clean(model.residual(one)), train) for one in seen], nan=np.inf)
    if np.min(left, initial=np.inf) >= found.train:
        return found
    again = score(model, fit(model, Candidate(others[np.argmin(left)])))
    return again if again.train < found.train else found


def begun_anew(leader: Scored, as_built: Gaps, clock: Clock) -> Scored:
    """A leader that leaves a gap, fitted from other sizes of what does not grow with them, about that machine.

    What slips or not changes how all else swings: about the wrong machine even the true size leaves more.
    """
    most_gone = leader.train < near(leader.model, as_built[0])
    if solved(as_built, leader) or not most_gone or not leader.model.facts.oscillatory:
        return leader
    ends = [leader]
    for start in _beginnings(leader):
        if clock.over(f"other sizes of {leader.label}"):
            break
        clock.tell(f"{leader.label} begun anew")
        found = _about_its_start(leader.model, Candidate(start))
        ends.append(refine(found, as_built, clock) if found.train < leader.train else found)
    return alternatives(ends, as_built[0])


def _about_its_start(model: Linearisation, candidate: Candidate) -> Scored:
    """Fitted about the machine that it starts from."""
    estimate = model.posterior.estimate(model.residual(*model.predict([candidate.effects])))
    about = model.relinearised(candidate.effects, estimate)
    return score(about, fit(about, candidate))


def _beginnings(leader: Scored) -> Iterator[tuple[Effect, ...]]:
    """With one effect at a point of its screening that no weight scales, each such point a start of its own.

    Or with a size that has a grid where that costs least beside the others.
    """
    for k, point in _unscaled(leader.fit.effects):
        yield _with(leader.fit.effects, k, point)
    candidate = Candidate(leader.fit.effects)
    yield from map(candidate.at, grid_starts(leader.model.coarse, candidate))


def _unscaled(effects: tuple[Effect, ...]) -> list[tuple[int, Values]]:
    """By number of the effect, points of its screening that no weight scales."""
    groups = [(k, type(e), e.site, group) for k, e in enumerate(effects) for group in type(e).screening(e.site)]
    alone = [(k, kind, site, group[0]) for k, kind, site, group in groups if len(group) == 1]
    return [(k, point) for k, kind, site, point in alone if kind.combine(site, [point], np.array([2.0])) == point]


def _with(effects: tuple[Effect, ...], number: int, values: Values) -> tuple[Effect, ...]:
    """With other values of one of them."""
    one = effects[number]
    return *effects[:number], type(one)(one.site, **{**one.values, **values}), *effects[number + 1 :]
