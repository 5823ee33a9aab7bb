"""What a diagnosis concludes from scored explanations: the verdict, the best explanation, and what ties with it."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from boom_mj.diagnosis.budget import Budget, Odds, any_needed, gap_budget, inclusion, needed, odds
from boom_mj.diagnosis.clock import Clock
from boom_mj.diagnosis.criteria import Criteria
from boom_mj.diagnosis.decision import choose, explains, solved, sure, ties_with
from boom_mj.diagnosis.linearisation import Linearisation
from boom_mj.diagnosis.outlying import Outlier
from boom_mj.diagnosis.scoring import Scored, held_out_closure, simplest_gap
from boom_mj.diagnosis.screening import Screened
from boom_mj.diagnosis.stand_in import freed
from boom_mj.effects import Effect
from boom_mj.estimation.bootstrap import Closure, gap
from boom_mj.systems.system import Designs, ResidualForce, ResidualForces, separating_experiments

Array = np.ndarray


@dataclass(frozen=True, eq=False)
class Diagnosis:
    """What was found.

    Attributes:
        verdict: consistent, explained, ambiguous, partial or unexplained.
        best: the explanation, None where nothing helps.
        scored: all scored candidates, best first.
        ties: rivals that the data cannot tell from the best.
        as_built: whitened residual of the machine as built, with the nuisances that leave least of it, (N,).
        closure: of the best on held-out entries.
        fidelity_alone: share of the coarse model's held-out gap that a finer one closes by itself.
        next_experiment: that would separate the ties.
        model: the healthy machine, about which all this is said.
        odds: probabilities of the scored candidates, in their order, and of what else there is.
        skipped: what was not looked at for want of time.
        freed: the best explanation with a joint's resistance set free, where its law is another (`stand_in`).
        simplest: held-out gap that the simplest model leaves, with the explanation or without; None where not tried.
        outliers: what was left out, since nothing explains it: all else is about the rest.
        with_outliers: what was found before; None without any.
    """

    verdict: str
    best: Scored | None
    scored: tuple[Scored, ...]
    ties: tuple[Scored, ...]
    screened: tuple[Screened, ...]
    as_built: Array
    closure: Closure
    fidelity_alone: float
    next_experiment: str | None
    model: Linearisation
    odds: Odds
    skipped: tuple[str, ...] = ()
    freed: tuple[Scored, ...] = ()
    simplest: float | None = None
    outliers: tuple[Outlier, ...] = ()
    with_outliers: "Diagnosis | None" = None

    def but_for(self, outliers: tuple[Outlier, ...], with_outliers: "Diagnosis | None") -> "Diagnosis":
        """The diagnosis of the rest as one of the whole: something is at work that nothing explains."""
        if not outliers:
            return self
        odds = replace(self.odds, outside_library=self.odds.outside_library + self.odds.none, none=0.0)
        rest = replace(self, verdict="partial", odds=odds, outliers=outliers, with_outliers=with_outliers)
        return rest if self.solved and any(rest.sure) else replace(rest, verdict="unexplained")

    @property
    def criteria(self) -> Criteria:
        """What decided."""
        return self.model.criteria

    def after(self, change: Callable[[Scored], Scored]) -> "Diagnosis":
        """With the best explanation and its ties changed; unexplained where none of its causes shows any more."""
        if self.best is None:
            return self
        ends = {id(one): change(one) for one in (self.best, *self.ties)}
        scored = tuple(ends.get(id(one), one) for one in self.scored)
        found = replace(self, best=ends[id(self.best)], ties=tuple(ends[id(one)] for one in self.ties), scored=scored)
        return found if any(found.named) or not any(self.named) else replace(found, verdict="unexplained")

    @property
    def solved(self) -> bool:
        """Whether the gap has an explanation, or several that do as well."""
        return self.verdict in ("explained", "ambiguous")

    @property
    def residual(self) -> Array:
        """What the explanation leaves, whitened, (N,)."""
        return self.best.fit.residual if self.best else self.as_built

    @cached_property
    def sure(self) -> tuple[bool, ...]:
        """Of the effects of the best explanation: whether nothing else does what they do, or if all but outliers is
        explained whether they are likely."""
        if not self.best:
            return ()
        effects = self.best.fit.effects
        if self.outliers and not self.ties:
            least = self.criteria.named_probability
            likely = (inclusion(self.odds, self.scored, effect) >= least for effect in effects)
            return tuple(so and self._shows(effect) for so, effect in zip(likely, effects))
        rivals = (*self.scored, *self.freed)
        return tuple(needed(self.best, rivals, self.as_built, effect) for effect in effects)

    @property
    def named(self) -> tuple[bool, ...]:
        """Of the effects of the best explanation, which the verdict names; the others are suspects.

        Where sizes allow for small effects that are not named, one that may be nothing is a suspect.
        """
        if self.verdict == "partial":
            return self.sure
        return tuple(self.solved and self._shows(effect) for effect in (self.best.fit.effects if self.best else ()))

    def _shows(self, effect: Effect) -> bool:
        """Whether an effect of the best explanation is more than what a little of others could be taken for."""
        return not self.criteria.unnamed or (self.best is not None and self.best.shows(effect))

    @property
    def closed_by_little(self) -> bool:
        """Whether an explanation suffices of whose effects none is sure, since a little of others may do the same."""
        if self.verdict != "unexplained" or self.best is None or not self.criteria.unnamed:
            return False
        gaps = gap(self.as_built, self.model.data.train), gap(self.as_built, self.model.data.held_out)
        return solved(gaps, self.best) and not any(map(self.best.shows, self.best.fit.effects))

    @cached_property
    def budget(self) -> Budget | None:
        """What the effects of the best explanation take of the held-out gap."""
        return gap_budget(self.best) if self.best else None

    @cached_property
    def trained(self) -> Array:
        """What the explanation leaves or, where that is much, what explains all of training, whitened, (N,)."""
        most = [j for j in self.scored if j.train <= self.criteria.explained_gap]
        if not most or gap(self.residual, self.model.data.train) <= self.criteria.near_noise_gap:
            return self.residual
        return min(most, key=lambda j: j.train).fit.residual

    @cached_property
    def not_trained(self) -> dict[int, float]:
        """Recordings held out, by index, with a gap where training has none or an explanation, and it.

        Where training has none, even an explanation has its sizes from recordings that hardly inform of them.
        """
        data, near_noise = self.model.data, self.criteria.near_noise_gap
        learnt = self.solved and gap(self.as_built, data.train) > self.criteria.healthy_gap
        if learnt or data.split_in_time or gap(self.trained, data.train) > near_noise:
            return {}
        residual = self.as_built if self.solved else self.trained
        rows = (data.held_out & (data.recording_of == k) for k in range(len(data.recordings)))
        left = {k: gap(residual, own) for k, own in enumerate(rows)}
        return {k: size for k, size in left.items() if size > near_noise}

    @cached_property
    def forces(self) -> tuple[ResidualForce, ...]:
        """What would move the machine as built to where it was; none where channels do not tell where that is."""
        system, model = self.model.system, self.model
        if not isinstance(system, ResidualForces):
            return ()
        return system.forces(model.data, self.as_built, model.noise.weight)


def concluded(
    model: Linearisation,
    as_built: Array,
    screened: Sequence[Screened],
    scored: Sequence[Scored],
    mimicked: Sequence[float] | None,
    unseen: float,
    clock: Clock,
) -> Diagnosis:
    """What scores say; `mimicked` of every scored explanation, and `unseen`: see `odds`."""
    data, criteria = model.data, model.criteria
    gaps = _, before = gap(as_built, data.train), gap(as_built, data.held_out)
    best = choose(scored, gaps)
    if best and before <= criteria.near_noise_gap and not sure(as_built, best):
        best = None
    share = held_out_closure(model, as_built, best.fit.residual if best else as_built)
    verdict = "unexplained" if best or before > criteria.healthy_gap else "consistent"
    ties, other_laws = tuple[Scored, ...](), tuple[Scored, ...]()
    if best and explains(gaps, best, share):
        rivals = (j for j in scored if j is not best and solved(gaps, j))
        ties = tuple(j for j in rivals if ties_with(model, best, j, before))
        verdict = "ambiguous" if ties else "explained"
    elif best and 1 - criteria.shadow >= criteria.named_probability and any_needed(best, scored, as_built):
        other_laws = tuple(freed(best, clock))
        verdict = "partial" if any_needed(best, (*scored, *other_laws), as_built) else "unexplained"
        if criteria.gain_z and verdict == "partial":  # what is left does not hide that others leave as much
            ties = tuple(j for j in scored if j is not best and ties_with(model, best, j, before))
    following = None
    if best and ties:
        clock.tell("the next experiment")
        following = _next_experiment(model, [j.fit.effects for j in (best, *ties)])
    (coarse,) = model.predictor.predict([()], model.facts.fidelity.coarse)
    coarse = model.clean(model.noise.white(data.measured - coarse))
    fidelity = held_out_closure(model, coarse, as_built).value
    return Diagnosis(
        verdict,
        best,
        tuple(scored),
        ties,
        tuple(screened),
        as_built,
        share,
        fidelity,
        following,
        model,
        odds(as_built, scored, model, mimicked, unseen),
        clock.skipped,
        other_laws,
        simplest_gap(model, best) if verdict in ("unexplained", "partial") else None,
    )


def _next_experiment(model: Linearisation, rivals: Sequence[tuple]) -> str | None:
    if isinstance(model.system, Designs):
        return model.system.next_experiment(rivals, [log.name for log in model.data.recordings])
    return separating_experiments(rivals)
