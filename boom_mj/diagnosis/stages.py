"""Search stages: single causes, then combinations, fitted roughly; the leaders are refined about what they make."""

from collections.abc import Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from boom_mj.diagnosis.candidate import Candidate
from boom_mj.diagnosis.clock import Clock
from boom_mj.diagnosis.decision import Gaps, choose, leaps, solved, sure, useful
from boom_mj.diagnosis.fitting import fit, grid_starts
from boom_mj.diagnosis.linearisation import Linearisation
from boom_mj.diagnosis.merging import likes_of, wholes_of
from boom_mj.diagnosis.partners import hidden_partners, pairs_of, partners_of, shared, shortlist, without_the_least
from boom_mj.diagnosis.refining import begun_anew, near, refine
from boom_mj.diagnosis.scoring import Scored, score
from boom_mj.diagnosis.screening import Screened, Screening
from boom_mj.estimation.least_squares import OPTIONS


def singles(model: Linearisation, screened: Sequence[Screened], as_built: Gaps, clock: Clock) -> list[Scored]:
    """The best few of a screening, fitted and scored, best first."""
    clock.tell("fitting " + ", ".join(s.candidate.label for s in screened[: model.budget.finalists]))
    promised = [(start, s.share) for s in shortlist(model, screened) for start in s.starts]
    return _fit_by_promise(model, promised, as_built[0], clock)


def refined(scored: list[Scored], as_built: Gaps, clock: Clock) -> list[Scored]:
    """Single causes, the leaders refined, and simplified where that suffices."""
    scored = _refined(scored, as_built, clock)
    return _simplified(scored, as_built, clock) if scored and solved(as_built, scored[0]) else scored


def combined(
    scored: list[Scored], as_built: Gaps, screening: Screening, clock: Clock, most: int | None
) -> list[Scored]:
    """With combinations, where single causes do not decide, or one decides that may hide another; simplified.

    Args:
        screening: of the library about the machine as built.
        most: causes of a combination; see `diagnose`.
    """
    budget, together = screening.model.budget, most or screening.model.facts.max_causes
    begun, by_error = set[tuple](), bool(screening.model.criteria.gain_z)
    for size in range(2, 1 + (most or max(together, budget.revealed))):
        if not scored or clock.over(f"{size} causes together"):
            return scored
        if by_error and _stuck(scored, as_built, size):
            break
        scored = _anew(scored, as_built, begun, clock)
        leader = (choose(scored, as_built) if by_error else None) or scored[0]
        if not solved(as_built, leader):
            last = size == together
            scored = _combine(scored, size, as_built, screening, clock, last) if size <= together else scored
        elif not by_error and (shown := _shown(scored, as_built, size - 1)):
            scored = _revealed(shown, scored, screening, clock)
        if by_error and size <= together:
            scored = _swapped(scored, as_built, screening, clock)
    scored = _anew(scored, as_built, begun, clock)
    if not by_error and scored[0].train < near(scored[0].model, as_built[0]):
        scored = _swapped(scored, as_built, screening, clock)
    scored = _merged(scored, as_built, screening, clock)
    worth = by_error or any(solved(as_built, j) for j in scored)
    return _simplified(scored, as_built, clock) if worth else scored


def _stuck(scored: list[Scored], as_built: Gaps, size: int) -> bool:
    """Whether neither of the last two causes that were added before so many was worth it."""
    chosen = choose(scored, as_built)
    return size > 3 and (chosen is None or len(chosen.fit.effects) < size - 2)


def _anew(scored: list[Scored], as_built: Gaps, begun: set[tuple], clock: Clock) -> list[Scored]:
    """With the leader begun anew, but for causes that were begun so before."""
    places = scored[0].fit.candidate.places
    anew = scored[0] if places in begun else begun_anew(scored[0], as_built, clock)
    begun.add(places)
    return scored if anew is scored[0] else best_of_each([anew, *scored])


def _fit_by_promise(
    model: Linearisation, promised: Sequence[tuple[Candidate, float]], before: float, clock: Clock
) -> list[Scored]:
    """Candidates that promise a share of a gap; where the best of a machine that swings close most of it, these only.

    Args:
        promised: best first.
        before: the gap in training.
    """
    budget, (_, most) = model.budget, max(promised, key=lambda one: one[1], default=(None, 0.0))
    enough = 1 - budget.close**2 * (1 - most) if model.facts.oscillatory else 0.0
    likely = [one for k, (one, share) in enumerate(promised) if share >= enough or k < budget.always]
    others = [one for one, _ in promised if one not in likely]
    found = fit_all(model, likely, clock)
    if others and not (found and found[0].train < near(model, before)):
        found = best_of_each([*found, *fit_all(model, others, clock)])
    return found


def fit_all(model: Linearisation, candidates: Sequence[Candidate], clock: Clock) -> list[Scored]:
    coarse, oscillatory = model.coarse, model.facts.oscillatory
    slow, best = coarse.blurred, np.inf

    def scored(candidate: Candidate) -> Scored | None:
        if clock.over(candidate.label):
            return None
        own = coarse.conditional_on(candidate.effects)
        others = grid_starts(own, candidate)
        if oscillatory:
            others.append(fit(slow.conditional_on(candidate.effects), candidate, OPTIONS.start, clock=clock).scaled)
        return score(own, fit(own, candidate, others=others, clock=clock))

    found: list[Scored] = []
    with ThreadPoolExecutor(max(1, len(candidates))) as threads:
        for count, one in enumerate(threads.map(scored, candidates), 1):
            if one and one.held_out < best:
                best = one.held_out
                clock.tell(f"{count} of {len(candidates)} fitted, best so far {one.label}: gap {best:.2f}")
            found += [one] if one else []
    return best_of_each(found)


def best_of_each(found: Iterable[Scored]) -> list[Scored]:
    """Of those with the same causes at the same sites the best, best first."""
    best: dict[tuple, Scored] = {}
    for one in sorted(found, key=lambda j: j.held_out):
        best.setdefault(one.fit.candidate.places, one)
    return list(best.values())


def _combine(
    scored: list[Scored], size: int, as_built: Gaps, screening: Screening, clock: Clock, last: bool
) -> list[Scored]:
    """Forward, with a swap: partners for the leader, others for one that was there before, then for the next leader.

    Only as long as no partner has closed half of what was left, unless no more may follow.
    """
    model = scored[0].model
    leaders = [j for j in scored if len(j.fit.effects) == size - 1 and useful(j, as_built)]
    saving = model.facts.oscillatory
    leaders = leaders[: model.budget.leaders if saving else model.budget.trunks]
    trunks = [(_about(j, as_built, screening.model), j.fit.effects) for j in leaders]
    before, seen = scored[0].gaps, set[tuple]()

    def enough() -> bool:
        """Where all is soon tried a tie is worth the look."""
        return saving if solved(as_built, scored[0]) else not last and leaps(scored[0], before)

    while trunks and not enough():
        about, trunk = trunks.pop(0)
        if (machine := (id(about), Candidate(trunk).places)) in seen:
            continue
        pairs = pairs_of(trunk, partners_of(about, trunk, screening, clock)) + shared(trunk, scored)
        scored = _paired(scored, about, pairs, before, clock)
        stuck = not solved(as_built, scored[0]) and not leaps(scored[0], before)
        if saving and not last and not seen and stuck:
            others = hidden_partners(about, trunk, screening, clock)
            scored = _paired(scored, about, pairs_of(trunk, others), before, clock)
        if not seen and len(scored[0].fit.effects) == size:
            trunks.insert(0, (_about(scored[0], as_built, screening.model), without_the_least(scored[0])))
        seen.add(machine)
    return scored


def _about(found: Scored, as_built: Gaps, nominal: Linearisation) -> Linearisation:
    """The machine about which more causes are fitted: as an explanation makes it, or nominal if that leaves much.

    Nuisances of an explanation that leaves much are as wrong as it is, and vibrations do not let go of them.
    """
    much = nominal.facts.oscillatory and found.train > near(nominal, as_built[0])
    return nominal if much else found.model


def _shown(scored: Sequence[Scored], as_built: Gaps, size: int) -> Scored | None:
    """What is chosen, if it has so many causes, or the best of these that surely adds some to it.

    Beside a cause whose inaccuracy may be all that is left, others are chosen only together (`_with_more`).
    """
    chosen = choose(scored, as_built)
    if not chosen or len(chosen.fit.effects) == size:
        return chosen
    causes = set(chosen.fit.candidate.places)
    more = (j for j in scored if len(j.fit.effects) == size and causes < set(j.fit.candidate.places))
    return next((j for j in more if j.train < chosen.train and sure(chosen.fit.residual, j)), None)


def _revealed(leader: Scored, scored: list[Scored], screening: Screening, clock: Clock) -> list[Scored]:
    """With pairs of a leader that suffices, where screening promises what counts: at a glance, then about it."""
    model, trunk = leader.model, leader.fit.effects
    least = model.criteria.least_gain / leader.train**2
    glance = screening.promises(trunk, model.residual(*model.predict([trunk])), model, leader.fit.jacobian)
    if max(glance.values(), default=0.0) < least:
        return scored
    partners = [partner for partner in partners_of(model, trunk, screening, clock) if partner.share >= least]
    return _paired(scored, model, pairs_of(trunk, partners), leader.gaps, clock) if partners else scored


def _paired(
    scored: list[Scored], model: Linearisation, pairs: Sequence[tuple[Candidate, float]], before: Gaps, clock: Clock
) -> list[Scored]:
    """With combinations, by what they promise; those tried before only where fits are short, from another start."""
    tried, again = {one.fit.candidate.places for one in scored}, not model.facts.oscillatory
    pairs = [(pair, share) for pair, share in pairs if again or pair.places not in tried]
    clock.tell("combinations: " + ", ".join(dict.fromkeys(pair.label for pair, _ in pairs)))
    rough = _fit_by_promise(model, pairs, before[0], clock)
    found = _refined(rough, before, clock)
    return best_of_each([*scored, *(j for j in found if j not in rough or j.fit.candidate.places not in tried)])


def _merged(scored: list[Scored], as_built: Gaps, screening: Screening, clock: Clock) -> list[Scored]:
    """With one cause in the place of several of what suffices, as long as that is chosen."""
    leader = choose(scored, as_built)
    while leader and solved(as_built, leader):
        tried = {j.fit.candidate.places for j in scored}
        wholes = [one for one in wholes_of(leader, screening, as_built[0]) if one.places not in tried]
        if not wholes or clock.over("one cause in the place of several"):
            break
        clock.tell("one cause in the place of several: " + ", ".join(one.label for one in wholes))
        found = _refined(fit_all(leader.model, wholes, clock), as_built, clock)
        scored = best_of_each([*scored, *found])
        chosen = choose(scored, as_built)
        if chosen not in found:
            break
        leader = chosen
    return scored


def _swapped(scored: list[Scored], as_built: Gaps, screening: Screening, clock: Clock) -> list[Scored]:
    """With a cause in the place of one of the leader's that it is like, as long as that leaves less (`helped`).

    Of what suffices as well: until nothing is left a like of the true cause may.
    """
    criteria = scored[0].model.criteria
    most = criteria.near_noise_gap if criteria.gain_z else criteria.floor
    while max((leader := scored[0]).gaps) > most and not clock.over("causes like those found"):
        tried = {j.fit.candidate.places for j in scored if criteria.gain_z or j.refined}
        likes = [one for one in likes_of(leader, screening) if one.places not in tried]
        if likes:
            clock.tell("in the place of one that is like it: " + ", ".join(one.label for one in likes))
            scored = best_of_each([*scored, *_refined(fit_all(leader.model, likes, clock), as_built, clock)])
        if scored[0].held_out > leader.model.budget.helped * leader.held_out:
            break
    return scored


def _simplified(scored: list[Scored], as_built: Gaps, clock: Clock) -> list[Scored]:
    """With what remains of the leader with one effect or some parameters less, as long as that is chosen."""
    leader, budget = scored[0], scored[0].model.budget
    if leader.model.criteria.gain_z:  # it goes by another score
        leader = choose(scored, as_built) or leader
    while leader:
        known = {j.fit.candidate.places: j.held_out for j in reversed(scored)}
        parts = fit_all(leader.model, list(Candidate(leader.fit.effects).simpler()), clock)
        for part in sorted(parts, key=lambda j: len(j.fit.scaled)):
            before = known.get(part.fit.candidate.places, np.inf)
            if part.held_out < min(budget.close * leader.held_out, budget.helped * before):
                part = refine(part, as_built, clock)
            if part.held_out < budget.helped * before:
                scored = best_of_each([*scored, part])
                if choose(scored, as_built) is part:
                    break
        chosen = choose(scored, as_built)
        if not chosen or len(chosen.fit.scaled) >= len(leader.fit.scaled):
            break
        leader = chosen
    return scored


def _refined(scored: Sequence[Scored], as_built: Gaps, clock: Clock) -> list[Scored]:
    """Those that are worth it refined.

    They come close to the best and leave less than almost all that there was, or fit training so well that what they
    say of recordings held out may be a matter of sizes that training hardly informs.
    """
    if not scored:
        return []
    model, budget = scored[0].model, scored[0].model.budget
    hope = budget.hope if model.facts.oscillatory else 1.0  # where refining is soon done
    enough, well = 1 + hope * (as_built[1] - 1), near(model, as_built[0])
    close = [j for j in scored if j.held_out < min(budget.close * scored[0].held_out, enough)][: budget.leaders]
    close += [j for j in sorted(scored, key=lambda j: j.train)[:1] if j not in close and j.train < well]
    done: list[Scored] = []
    for one in close:
        ahead = min((j.held_out for j in done), default=np.inf)
        if one.held_out - ahead > budget.rival * (as_built[1] - 1) and solved(as_built, done[0]):
            done.append(one)
            continue
        done.append(refine(one, as_built, clock))
        clock.tell(f"{one.label} refined: held-out gap {one.held_out:.2f} -> {done[-1].held_out:.2f}")
    return sorted([*done, *(j for j in scored if j not in close)], key=lambda j: j.held_out)
