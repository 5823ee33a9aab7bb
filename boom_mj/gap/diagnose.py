"""The diagnosis: fidelity and nuisances, screening, contest, combinations, and judgement on held-out data."""

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from threadpoolctl import threadpool_limits

from boom_mj.gap.campaign import Campaign
from boom_mj.gap.candidate import Candidate, everywhere
from boom_mj.gap.fit import ROUGH, START, fit
from boom_mj.gap.judge import Closure, Judged, closure, gap, judge, worse_by
from boom_mj.gap.metric import Metric, anchored, around, beside, blurred, coarsely, make_metric
from boom_mj.gap.screen import Screened, Signatures, spectral_lines
from boom_mj.gap.subject import Push

Array = np.ndarray
FINALISTS = 6  # singles that are fitted
SECONDS = 2  # partners tried for each of the best singles
LEADERS = 2  # of which combinations are tried, and which are fitted again
SMALLEST = 0.10  # fall of the held-out mean square that counts
QUIET = 1.15  # held-out gap up to which nothing needs explaining
SETTLED = 1.06  # gap that an explanation may leave, held out or not; right ones leave 0.95 to 1.01
ROUNDS, WORSE = 3, 1.2  # of polishing, and the growth of the training gap at which it is given up
HELPED, FAR = 0.98, 0.25  # of the training gap that polishing must leave to go on, if more than this of the gap is left
NEAR = 0.05  # of a size worth finding, within which nuisances and model error stay what they are
HOPE = 0.9  # of what there was to explain: what leaves more is not fitted again
CLOSE = 1.5  # times the best held-out gap, up to which a rival is fitted again
TIE = 0.03  # closure within which rivals tie


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
    best: Judged | None
    contest: tuple[Judged, ...]
    ties: tuple[Judged, ...]
    screened: tuple[Screened, ...]
    nominal: Array
    closure: Closure
    fidelity_alone: float
    next_experiment: str | None
    metric: Metric

    @cached_property
    def pushes(self) -> tuple[Push, ...]:
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
    learnt, before = (gap(metric, nominal, rows) for rows in (campaign.train, campaign.held_out))
    tell(f"nominal gap {learnt:.2f} in training, {before:.2f} held out; screening")
    signatures = Signatures(metric, everywhere(campaign.subject, without), spectral_lines(metric, nominal))
    screened = signatures.rank(raw)
    tell("contest of " + ", ".join(s.candidate.label for s in screened[:FINALISTS]))
    contest = _fit_all(metric, [s.candidate for s in shortlist(screened)])
    if contest and before > QUIET:
        contest = _polished(contest, before, tell)
        contest = sorted([*contest, *_fit_all(metric, _simpler(contest))], key=lambda j: j.held_out)
        for size in range(2, campaign.subject.causes + 1):
            if not solved((learnt, before), contest[0]):
                contest = _combine(contest, size, without, tell)
        contest = _without_one(contest, before)
    best = choose(contest, before)
    share = closure(metric, nominal, best.fit.residual if best else nominal, campaign.held_out)
    verdict = "consistent" if before <= QUIET else "unexplained"
    ties: tuple[Judged, ...] = ()
    if best and solved((learnt, before), best):
        ties = tuple(j for j in contest if j is not best and _ties(metric, best, j, before))
        verdict = "ambiguous" if ties else "explained"
    elif best and before <= QUIET and before**2 - best.held_out**2 < 2 * SMALLEST:
        best = None
    following = None
    if best and ties:
        tell("the next experiment")
        explanations = [j.fit.effects for j in (best, *ties)]
        following = campaign.subject.next_experiment(explanations, [log.name for log in campaign.recordings])
    coarse = metric.clean(metric.white(campaign.measured - campaign.predict([()], campaign.subject.fidelity.coarse)[0]))
    fidelity = closure(metric, coarse, nominal, campaign.held_out).value
    return Diagnosis(verdict, best, tuple(contest), ties, tuple(screened), nominal, share, fidelity, following, metric)


def shortlist(screened: Sequence[Screened]) -> list[Screened]:
    """The best few, and the best of each kind that explains a share worth a rollout."""
    chosen = list(screened[:FINALISTS])
    kinds = {s.candidate.effects[0].id for s in chosen}
    for s in screened[FINALISTS:]:
        if s.candidate.effects[0].id not in kinds and s.share > 0.3 * screened[0].share and len(chosen) < FINALISTS + 3:
            chosen.append(s)
            kinds.add(s.candidate.effects[0].id)
    return chosen


def _fit_all(metric: Metric, candidates: Sequence[Candidate]) -> list[Judged]:
    coarse = coarsely(metric)
    slow = blurred(coarse)

    def judged(candidate: Candidate) -> Judged:
        own = beside(coarse, candidate.effects)
        first = fit(beside(slow, candidate.effects), candidate, START) if metric.campaign.subject.swings else None
        return judge(own, fit(own, candidate, ROUGH, first.coordinates if first else None))

    with ThreadPoolExecutor(max(1, len(candidates))) as threads:
        found = list(threads.map(judged, candidates))
    return sorted(found, key=lambda j: j.held_out)


def solved(nominal: tuple[float, float], found: Judged) -> bool:
    """Whether an explanation leaves no more than noise and its own inaccuracy, learnt from and held out."""
    slack, left = found.metric.campaign.subject.slack, (found.train, found.held_out)
    return all(after <= SETTLED + slack * (before - 1) for before, after in zip(nominal, left))


def _simpler(contest: Sequence[Judged]) -> list[Candidate]:
    """The best effect at places where it has fewer knobs, such as roll alone for roll and pitch."""
    (effect, *others), kind = contest[0].fit.effects, type(contest[0].fit.effects[0])
    tried = {judged.fit.candidate.places for judged in contest}
    found = []
    for place in kind.locations():
        knobs = set(kind.knobs(place))
        if knobs < set(kind.knobs(effect.location)) and not others:
            candidate = Candidate((kind(place, **{name: effect.values[name] for name in knobs}),))
            found += [candidate] if candidate.places not in tried else []
    return found


def _combine(contest: list[Judged], size: int, without: Sequence[str], tell: Callable[[str], None]) -> list[Judged]:
    """Forward: partners for the leaders, by screening again about the machine that each leader makes."""
    candidates: dict[tuple, Candidate] = {}
    for leader in [judged for judged in contest if len(judged.fit.effects) == size - 1][:LEADERS]:
        tell(f"screening beside {leader.label}")
        known, metric = leader.fit, leader.metric
        signatures = Signatures(
            metric, everywhere(metric.campaign.subject, without), spectral_lines(metric, known.residual), known.effects
        )
        raw = metric.residual(*metric.predict([known.effects]))
        for partner in signatures.rank(raw, known.jacobian)[:SECONDS]:
            pair = Candidate((*known.effects, *partner.candidate.effects))
            candidates.setdefault(pair.places, pair)
    tell("combinations: " + ", ".join(p.label for p in candidates.values()))
    found = _fit_all(contest[0].metric, list(candidates.values()))
    return sorted([*contest, *_polished(found, contest[0].held_out, tell)], key=lambda j: j.held_out)


def _without_one(contest: list[Judged], before: float) -> list[Judged]:
    """The contest, and what remains of its leading combination without one of its effects, from where it has them."""
    best = contest[0]
    if len(best.fit.effects) == 1:
        return contest
    parts = [Candidate(tuple(e for e in best.fit.effects if e is not one)) for one in best.fit.effects]
    fitted = _fit_all(best.metric, parts)
    found = [*contest, *(_polish(j, before) if j.held_out < CLOSE * best.held_out else j for j in fitted)]
    best_of = {j.fit.candidate.places: j for j in sorted(found, key=lambda j: -j.held_out)}
    return sorted(best_of.values(), key=lambda j: j.held_out)


def _polished(contest: Sequence[Judged], before: float, tell: Callable[[str], None]) -> list[Judged]:
    """The best fitted again, and those that come close to it, unless they leave almost all that there was before."""
    enough = 1 + HOPE * (before - 1)
    close = [j for j in contest if j.held_out < min(CLOSE * contest[0].held_out, enough)][:LEADERS]
    polished = []
    for judged in close:
        polished.append(_polish(judged, before))
        tell(f"{judged.label} fitted again: held-out gap {judged.held_out:.2f} -> {polished[-1].held_out:.2f}")
    return sorted([*polished, *contest[len(close) :]], key=lambda j: j.held_out)


def _polish(judged: Judged, before: float) -> Judged:
    """Fit again from where the last fit has led, then with the nuisances and model error there, until it stays."""
    moved = np.array(np.inf)
    for number in range(1 + ROUNDS):
        metric, effects = judged.metric, judged.fit.effects
        estimate = metric.estimate(metric.residual(*metric.predict([effects])))
        same = number == 0 or (number > 1 and np.all(moved < NEAR))
        metric = (anchored if same else around)(metric, effects, estimate)
        again = judge(metric, fit(metric, Candidate(effects)))
        if again.train > WORSE * judged.train:
            break
        moved, helped = np.abs(again.fit.coordinates - judged.fit.coordinates), again.train < HELPED * judged.train
        judged, far = again, again.held_out > max(QUIET, 1 + FAR * (before - 1))
        if (number and np.all(moved < again.deviation)) or (far and not helped):
            break
    return judged


def choose(contest: Sequence[Judged], before: float) -> Judged | None:
    """The best single cause, with as few knobs as do, or more of them where each is worth it."""
    useful = [j for j in contest if before**2 - j.held_out**2 > SMALLEST]
    singles = [j for j in useful if len(j.fit.effects) == 1]
    best = min(singles, key=lambda j: j.held_out, default=None)
    best = _simplest(best, singles, before)
    for size in range(2, 1 + max((len(j.fit.effects) for j in useful), default=0)):
        best = _with_more(best, [j for j in useful if len(j.fit.effects) == size], contest, before)
    return best


def _with_more(
    best: Judged | None, larger: Sequence[Judged], contest: Sequence[Judged], before: float
) -> Judged | None:
    """The best explanation with one more cause, where it closes its share of what is left, or the best so far."""
    for judged in sorted(larger, key=lambda j: j.held_out):
        members = [j for j in contest if set(j.fit.candidate.places) < set(judged.fit.candidate.places)]
        alone = min([before, *(j.held_out for j in members), *([best.held_out] if best else [])])
        gain = alone**2 - judged.held_out**2
        subject = judged.metric.campaign.subject
        enough = gain > SMALLEST + subject.spill * (before**2 - alone**2)
        if enough and alone - judged.held_out > subject.worth * (alone - 1):
            return _simplest(judged, larger, before)
    return best


def _simplest(best: Judged | None, rivals: Sequence[Judged], before: float) -> Judged | None:
    """The same causes with fewer knobs, where the others do not close their share of what those leave."""
    for judged in rivals:
        if best and _nested(judged, best):
            subject = judged.metric.campaign.subject
            loss = judged.held_out**2 - best.held_out**2
            share = subject.worth * (judged.held_out - 1)
            same = [e.id for e in judged.fit.effects] == [e.id for e in best.fit.effects]
            if same and subject.spill:
                best = judged if loss < subject.spill * before**2 else best
            elif loss < SMALLEST or judged.held_out - best.held_out < share:
                best = judged
    return best


def _ties(metric: Metric, best: Judged, other: Judged, before: float) -> bool:
    """Whether a rival does as well within its uncertainty; supersets of the best do not count."""
    if set(best.fit.candidate.places) <= set(other.fit.candidate.places):
        return False
    if _nested(best, other) or len(other.fit.effects) > len(best.fit.effects):
        return False
    worse, error = worse_by(metric, best.fit.residual, other.fit.residual, metric.campaign.held_out)
    return (other.held_out - best.held_out) < TIE * (before - 1) and worse < 2 * error


def _nested(best: Judged, other: Judged) -> bool:
    """Whether the rival is the same effects, or what has them as special cases, with more freedom."""
    pairs = list(zip(best.fit.effects, other.fit.effects))
    alike = len(best.fit.effects) == len(other.fit.effects) and all(
        a.id == b.id or a.id in b.special_cases for a, b in pairs
    )
    return alike and len(other.fit.coordinates) > len(best.fit.coordinates)
