"""The discovery: the place and the formula of what a machine has and neither its model nor the library has."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from threadpoolctl import threadpool_limits

from boom_mj.diagnosis.candidate import Candidate, everywhere
from boom_mj.diagnosis.clock import Clock
from boom_mj.diagnosis.decision import sure
from boom_mj.diagnosis.linearisation import Linearisation, linearise
from boom_mj.diagnosis.lines import spectral_lines
from boom_mj.diagnosis.scoring import Scored, held_out_closure
from boom_mj.diagnosis.screening import Screening
from boom_mj.diagnosis.stages import best_of_each, fit_all, refined, singles
from boom_mj.discovery.forces import ForceInTime, forces_in_time
from boom_mj.discovery.search import FoundLaw, fitted, possible, sums
from boom_mj.discovery.where import places_of
from boom_mj.estimation.bootstrap import Closure, gap, worse_by
from boom_mj.systems.predictor import Predictor

Array = np.ndarray


@dataclass(frozen=True, eq=False)
class Discovery:
    """What was found.

    Attributes:
        verdict: "law" or "none".
        as_built: whitened residual of the machine as built, (N,).
        model: the healthy machine.
        skipped: what was not looked at for want of time.
        best: the law, or the best of the grammar where none is one; None where no law was fitted.
        front: of laws by size, each leaving less than all shorter ones, shortest first.
        ties: other laws of no more terms that the data cannot tell from the best.
        library: the library's effect that does best alone, None where none helps.
        same_as: it, where it does what the law does.
        withheld: an effect that was left out of the library and leaves less than the law.
        places: of every place the law that leaves least there, the best first.
        forces: without a formula, of every place that can be pushed, that which closes most first.
    """

    verdict: str
    as_built: Array
    model: Linearisation
    skipped: tuple[str, ...]
    best: FoundLaw | None = None
    front: tuple[FoundLaw, ...] = ()
    ties: tuple[FoundLaw, ...] = ()
    library: Scored | None = None
    same_as: Scored | None = None
    withheld: Scored | None = None
    places: tuple[FoundLaw, ...] = ()
    forces: tuple[ForceInTime, ...] = ()

    @property
    def healthy(self) -> bool:
        """Whether there is no gap, in training or held out."""
        data = self.model.data
        return max(gap(self.as_built, rows) for rows in (data.train, data.held_out)) <= self.model.criteria.healthy_gap

    @property
    def explained(self) -> bool:
        """Whether there is a law, or an effect of the library that surely closes most of the gap."""
        effects = [one.fit.residual for one in (self.library, self.withheld) if one]
        closures = (held_out_closure(self.model, self.as_built, after) for after in effects)
        return self.verdict == "law" or any(one.low > self.model.criteria.main_share for one in closures)

    @cached_property
    def closure(self) -> Closure:
        """Of the held-out gap, by the best law."""
        after = self.best.residual if self.best else self.as_built
        return held_out_closure(self.model, self.as_built, after)


def discover(
    predictor: Predictor, without: Sequence[str] = (), clock: Clock | None = None, forces: bool = False
) -> Discovery:
    """Find a law that closes a gap which no effect of the library closes.

    Args:
        predictor: of a system and its recordings.
        without: ids of effects that are withheld from the library.
        clock: how much time there is, and who hears one line per stage.
        forces: whether forces in time are estimated although the gap is explained.
    """
    clock = clock or Clock()
    with threadpool_limits(1):  # simulations have the cores
        found = _discover(predictor, without, clock)
        if found.healthy or (found.explained and not forces):
            return found
        raw = found.model.residual(found.model.base)
        return replace(found, forces=forces_in_time(found.model, raw, clock), skipped=clock.skipped)


def _discover(predictor: Predictor, without: Sequence[str], clock: Clock) -> Discovery:
    clock.tell("fidelity and nuisances")
    model = linearise(predictor)
    raw = model.residual(model.base)
    as_built = model.clean(raw)
    gaps = gap(as_built, model.data.train), gap(as_built, model.data.held_out)
    clock.tell(f"gap as built {gaps[0]:.2f} in training, {gaps[1]:.2f} held out")
    if max(gaps) <= model.criteria.healthy_gap:
        return Discovery("none", as_built, model, clock.skipped)
    places = possible(model, as_built, places_of(model))
    clock.tell(f"{sum(len(place.terms) for place in places)} terms at {len(places)} places")
    ranked = sums(model, raw, places) if places else []
    laws = sorted(fitted(model, ranked, gaps[0], clock), key=lambda found: found.held_out)
    chosen = _chosen(model, as_built, laws) if laws else None
    best = _refined(model, as_built, laws, gaps, clock) if laws else None
    clock.tell("the library")
    library = _library(model, raw, as_built, chosen, best.scored.model if best else model, without, clock)
    left = [one for one in library if one.fit.effects[0].id not in without]
    same = next((one for one in library if best and _alike(model, one.fit.residual, best.residual)), None)
    named = left[0] if left else None
    verdict = "law" if best and _is_law(model, as_built, best) else "none"
    if best and named and named is not same and _better(model, named.fit.residual, best.residual):
        verdict = "none"
    return Discovery(
        verdict,
        as_built,
        model,
        clock.skipped,
        best,
        front=_front(laws),
        ties=tuple(one for one in laws if best and _tied(model, best, one)),
        library=named,
        same_as=same,
        withheld=next(
            (one for one in library if one not in left and best and _better(model, one.fit.residual, best.residual)),
            None,
        ),
        places=_by_place(laws),
    )


def _front(laws: Sequence[FoundLaw]) -> tuple[FoundLaw, ...]:
    """Of every number of terms the law that leaves least, where it leaves less than all shorter ones."""
    found: list[FoundLaw] = []
    for count in sorted({len(law.terms) for law in laws}):
        best = min((law for law in laws if len(law.terms) == count), key=lambda law: law.held_out)
        if not found or best.held_out < found[-1].held_out:
            found.append(best)
    return tuple(found)


def _by_place(laws: Sequence[FoundLaw]) -> tuple[FoundLaw, ...]:
    """Of laws, the best first, the first of every place."""
    found: dict[int, FoundLaw] = {}
    for law in laws:
        found.setdefault(id(law.place), law)
    return tuple(found.values())


def _chosen(model: Linearisation, as_built: Array, laws: Sequence[FoundLaw]) -> FoundLaw:
    """The shortest law that leaves no more than the best beyond what chance does, or beyond its own inaccuracy.

    Laws with a term that may be 0 count only where there is no other.
    """
    laws = [law for law in laws if law.certain] or laws
    best = min(laws, key=lambda law: _left(model, law.residual))
    leaks = model.criteria.leakage * (_left(model, as_built) - _left(model, best.residual))

    def enough(law: FoundLaw) -> bool:
        loss, error = _loss(model, best.residual, law.residual)
        return loss <= max(model.criteria.tie_z * error, leaks)

    return min(filter(enough, laws), key=lambda law: (len(law.terms), law.size, _left(model, law.residual)))


def _refined(
    model: Linearisation, as_built: Array, laws: Sequence[FoundLaw], gaps: tuple[float, float], clock: Clock
) -> FoundLaw:
    """The chosen law, refined, or the best of the others, if that is chosen about the machine which the first makes.

    Fitted roughly, a law that is short of a term may leave no more than the rough model's own error hides, and one of
    many terms may owe what it leaves to that error.
    """
    chosen = _chosen(model, as_built, laws)
    best = replace(chosen, scored=refined([chosen.scored], gaps, clock)[0])
    others = [
        law for law in laws if law is not chosen and law.certain and law.held_out < model.budget.close * chosen.held_out
    ]
    rivals = sorted(others, key=lambda law: _left(model, law.residual))[:1]
    for again in fit_all(best.scored.model, [Candidate(law.scored.fit.effects) for law in rivals], clock):
        there = replace(rivals[0], scored=again)
        if _chosen(model, as_built, [best, there]) is there:
            return replace(there, scored=refined([again], gaps, clock)[0])
    return best


def _left(model: Linearisation, residual: Array) -> float:
    """Mean square of a whitened residual in all recordings: a few numbers fit training no better than the rest."""
    return float(np.mean(residual[model.data.train | model.data.held_out] ** 2))


def _loss(model: Linearisation, better: Array, worse: Array) -> tuple[float, float]:
    """By how much a residual is worse than another in all recordings, and the standard error of that."""
    rows = model.data.train | model.data.held_out
    return worse_by(model.data.windows[rows], better[rows], worse[rows])


def _library(
    model: Linearisation,
    raw: Array,
    as_built: Array,
    law: FoundLaw | None,
    about: Linearisation,
    without: Sequence[str],
    clock: Clock,
) -> list[Scored]:
    """The library's effects alone, the best first, of those that promise at least a share of what a law closes.

    The best, and the best of those that are not withheld, are fitted again about the machine that the law makes where
    they come close to it: what does the same leaves the same there, model error and nuisances included.

    Args:
        law: fitted roughly, as the effects are.
        about: the machine that the law makes.
    """
    if clock.over("the library"):
        return []
    gaps = gap(as_built, model.data.train), gap(as_built, model.data.held_out)
    fall = 1 - (gap(law.residual, model.data.train) / gaps[0]) ** 2 if law else 0.0
    screening = Screening(model, everywhere(model.system), spectral_lines(model, as_built))
    promising = [one for one in screening.rank(raw) if one.share >= model.criteria.main_share * fall]
    found = singles(model, promising, gaps, clock) if promising else []
    known = [one for one in found if one.fit.effects[0].id not in without]
    best = [one for one in found if one in (found[0], *known[:1])]
    rivals = [one.fit.effects for one in best if not law or one.held_out < model.budget.close * law.held_out]
    return best_of_each([*found, *fit_all(about, list(map(Candidate, rivals)), clock)])


def _alike(model: Linearisation, one: Array, other: Array) -> bool:
    """Whether a residual is as large as another, in what both change."""
    loss, error = _loss(model, other, one)
    return abs(loss) <= max(model.criteria.tie_z * error, model.criteria.law_gain)


def _better(model: Linearisation, better: Array, worse: Array) -> bool:
    """Whether a residual is smaller than another, beyond what chance does."""
    loss, error = _loss(model, better, worse)
    return loss > max(model.criteria.tie_z * error, model.criteria.law_gain)


def _tied(model: Linearisation, best: FoundLaw, other: FoundLaw) -> bool:
    if (other.terms == best.terms and other.place is best.place) or len(other.terms) > len(best.terms):
        return False
    loss, error = _loss(model, best.residual, other.residual)
    return loss <= model.criteria.tie_z * error


def _is_law(model: Linearisation, as_built: Array, best: FoundLaw) -> bool:
    """Whether a law closes most of the gap, in training and surely held out; of one near noise it must be no chance."""
    before, after = (gap(residual, model.data.train) for residual in (as_built, best.residual))
    trained = before - after > model.criteria.main_share * (before - 1)
    near = gap(as_built, model.data.held_out) <= model.criteria.near_noise_gap
    share = held_out_closure(model, as_built, best.residual)
    return trained and share.low > model.criteria.main_share and (not near or sure(as_built, best.scored))
