"""The diagnosis: fidelity and nuisances, screening, contest, combinations, and judgement on held-out data."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from threadpoolctl import threadpool_limits

from boom_mj.diagnosis.candidate import everywhere
from boom_mj.diagnosis.decision import QUIET, SETTLED, SMALLEST, choose, complete, explains, solved, sure, ties_with
from boom_mj.diagnosis.linearisation import Metric, make_metric
from boom_mj.diagnosis.scoring import Closure, Scored, closure, gap
from boom_mj.diagnosis.screening import Screened, Signatures, spectral_lines
from boom_mj.diagnosis.stages import combined, refined, singles
from boom_mj.systems.predictor import Campaign
from boom_mj.systems.system import ResidualForce

Array = np.ndarray
PROMISE = 0.01  # fall of the training mean square by screening, of which a quiet machine's best candidate stays short
HEALTHY = 1.05  # held-out gap up to which nothing needs explaining; healthy machines show 0.97 to 0.99


@dataclass(frozen=True)
class Diagnosis:
    """What was found.

    Attributes:
        verdict: consistent, explained, ambiguous or unexplained.
        best: the explanation, None where nothing helps.
        contest: all judged candidates, best first.
        ties: rivals that the data cannot tell from the best.
        nominal: whitened residual of the nominal model with its nuisances, (N,).
        closure: of the best on held-out entries.
        fidelity_alone: share of the coarse model's held-out gap that finer hinges close by themselves.
        next_experiment: of the catalogue, that would separate the ties.
        metric: in which all this is said.
    """

    verdict: str
    best: Scored | None
    contest: tuple[Scored, ...]
    ties: tuple[Scored, ...]
    screened: tuple[Screened, ...]
    nominal: Array
    closure: Closure
    fidelity_alone: float
    next_experiment: str | None
    metric: Metric

    @property
    def solved(self) -> bool:
        """Whether the gap has an explanation, or several that do as well."""
        return self.verdict in ("explained", "ambiguous")

    @property
    def residual(self) -> Array:
        """What the explanation leaves, whitened, (N,)."""
        return self.best.fit.residual if self.best else self.nominal

    @cached_property
    def taught(self) -> Array:
        """What the explanation leaves or, where that is much, what has learnt all that there was, whitened, (N,)."""
        most = [j for j in self.contest if j.train <= SETTLED]
        if not most or gap(self.residual, self.metric.campaign.train) <= QUIET:
            return self.residual
        return min(most, key=lambda j: j.train).fit.residual

    @cached_property
    def not_learnt(self) -> dict[int, float]:
        """Recordings held out, by index, with a gap where what is learnt from has none or an explanation, and it."""
        campaign = self.metric.campaign
        if self.solved or campaign.split_in_time or gap(self.taught, campaign.train) > QUIET:
            return {}
        rows = (campaign.held_out & (campaign.recording_of == k) for k in range(len(campaign.recordings)))
        left = {k: gap(self.taught, own) for k, own in enumerate(rows)}
        return {k: size for k, size in left.items() if size > QUIET}

    @cached_property
    def pushes(self) -> tuple[ResidualForce, ...]:
        """What would have to push the nominal model to where the machine is."""
        return self.metric.campaign.subject.pushes(self.metric, self.nominal)


def diagnose(
    campaign: Campaign, without: Sequence[str] = (), tell: Callable[[str], None] = lambda line: None
) -> Diagnosis:
    """Find what a campaign's machine has that the nominal model lacks.

    Args:
        without: ids of effects that are withheld from the library.
        tell: hears one line per stage.
    """
    with threadpool_limits(1):  # simulations have the cores
        return _diagnose(campaign, without, tell)


def _diagnose(campaign: Campaign, without: Sequence[str], tell: Callable[[str], None]) -> Diagnosis:
    tell("fidelity and nuisances")
    metric = make_metric(campaign)
    raw = metric.residual(metric.base)
    nominal = metric.clean(raw)
    gaps = learnt, before = gap(nominal, campaign.train), gap(nominal, campaign.held_out)
    tell(f"nominal gap {learnt:.2f} in training, {before:.2f} held out; screening")
    signatures = Signatures(metric, everywhere(campaign.subject, without), spectral_lines(metric, nominal))
    screened = signatures.rank(raw)
    contest = []
    if max(gaps) > HEALTHY or (screened and screened[0].share * learnt**2 > PROMISE):
        contest = singles(metric, screened, tell)
    worth = contest and (before > HEALTHY or before**2 - contest[0].held_out ** 2 > SMALLEST / 2)
    contest = refined(contest, gaps, tell) if worth else contest
    found = _concluded(metric, nominal, screened, contest, tell)
    other = None if found.solved else _borrowing(found, SETTLED, without, tell)
    if worth and not other and not complete(gaps, contest[0]):
        found = _concluded(metric, nominal, screened, combined(contest, gaps, without, tell), tell)
        other = None if found.solved else _borrowing(found, QUIET, without, tell)
    return other if other and other.solved else found


def _borrowing(found: Diagnosis, quiet: float, without: Sequence[str], tell: Callable[[str], None]) -> Diagnosis | None:
    """The diagnosis where part of a recording held out teaches what no recording to learn from shows; its rest judges.

    Args:
        quiet: what an explanation may leave of what is learnt from.
    """
    campaign = found.metric.campaign
    hidden = {k: size for k, size in found.not_learnt.items() if k not in campaign.borrowed}
    if not hidden or gap(found.taught, campaign.train) > quiet:
        return None
    most = max(hidden, key=hidden.__getitem__)
    part = f"{campaign.subject.words.learnt} of {campaign.recordings[most].name}"
    tell(f"recordings to learn from do not show the gap; learning from {part} as well")
    return _diagnose(campaign.borrowing(most), without, tell)


def _concluded(
    metric: Metric,
    nominal: Array,
    screened: Sequence[Screened],
    contest: Sequence[Scored],
    tell: Callable[[str], None],
) -> Diagnosis:
    """What a contest says."""
    campaign = metric.campaign
    gaps = _, before = gap(nominal, campaign.train), gap(nominal, campaign.held_out)
    best = choose(contest, gaps)
    if best and before <= QUIET and not sure(metric, nominal, best):
        best = None
    share = closure(metric, nominal, best.fit.residual if best else nominal, campaign.held_out)
    verdict = "unexplained" if best or before > HEALTHY else "consistent"
    ties: tuple[Scored, ...] = ()
    if best and explains(gaps, best, share):
        rivals = (j for j in contest if j is not best and solved(gaps, j))
        ties = tuple(j for j in rivals if ties_with(metric, best, j, before))
        verdict = "ambiguous" if ties else "explained"
    following = None
    if best and ties:
        tell("the next experiment")
        explanations = [j.fit.effects for j in (best, *ties)]
        following = campaign.subject.next_experiment(explanations, [log.name for log in campaign.recordings])
    coarse = metric.clean(metric.white(campaign.measured - campaign.predict([()], campaign.subject.fidelity.coarse)[0]))
    fidelity = closure(metric, coarse, nominal, campaign.held_out).value
    return Diagnosis(verdict, best, tuple(contest), ties, tuple(screened), nominal, share, fidelity, following, metric)
