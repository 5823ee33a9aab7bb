"""The diagnosis: fidelity and nuisances, screening, contest, combinations, and judgement on held-out data."""

from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from threadpoolctl import threadpool_limits

from boom_mj.effects import Effect
from boom_mj.gap.campaign import Campaign
from boom_mj.gap.candidate import Candidate, causes, everywhere
from boom_mj.gap.fit import ROUGH, SHARP, START, climb, fit, settle
from boom_mj.gap.judge import Closure, Judged, closure, gap, judge, worse_by
from boom_mj.gap.metric import Metric, anchored, around, beside, blurred, coarsely, make_metric
from boom_mj.gap.screen import Screened, Signatures, spectral_lines
from boom_mj.gap.subject import Push

Array = np.ndarray
Gaps = tuple[float, float]  # learnt from, held out
FINALISTS = 6  # singles that are fitted
SECONDS, RUNNERS = 3, 2  # partners that are tried: of those screened beside a leader, of those fitted without it
LEADERS = 2  # of a contest that are fitted again
FLOOR = 1.0  # gap of noise alone: an effect's own inaccuracy is not what another one closes down to it
SMALLEST = 0.10  # fall of the held-out mean square that counts
PROMISE = 0.01  # fall of the training mean square by screening, of which a quiet machine's best candidate stays short
HEALTHY = 1.05  # held-out gap up to which nothing needs explaining; healthy machines show 0.97 to 0.99
QUIET, SURE = 1.15, 4.0  # held-out gap up to which a cause must be sure, and in how many standard errors
SETTLED = 1.03  # gap that an explanation may leave, held out or not; right ones leave 0.95 to 1.01
WHOLE = 0.95  # closure that the interval of an explanation must reach
ROUNDS, WORSE = 3, 1.2  # of polishing, and the growth of the training gap at which it is given up
HELPED, FAR = 0.98, 0.25  # of a gap that fitting again must leave to go on, if more than this of the gap is left
NEAR = 0.1  # of a size worth finding, within which nuisances and model error stay what they are
HOPE = 0.9  # of what there was to explain: what leaves more is not fitted again
CLOSE = 1.5  # times the best held-out gap, up to which a rival is fitted again
RIVAL = 0.1  # of what there was to explain, up to which it is even where the best suffices
KNOB = 1e-3  # of the held-out gap, what a knob must be worth
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
    gaps = learnt, before = gap(nominal, campaign.train), gap(nominal, campaign.held_out)
    tell(f"nominal gap {learnt:.2f} in training, {before:.2f} held out; screening")
    signatures = Signatures(metric, everywhere(campaign.subject, without), spectral_lines(metric, nominal))
    screened = signatures.rank(raw)
    contest = []
    if max(gaps) > HEALTHY or (screened and screened[0].share * learnt**2 > PROMISE):
        tell("contest of " + ", ".join(s.candidate.label for s in screened[:FINALISTS]))
        contest = _fit_all(metric, [start for s in shortlist(screened) for start in s.starts])
    if contest and (before > HEALTHY or before**2 - contest[0].held_out ** 2 > SMALLEST / 2):
        contest = _polished(contest, gaps, tell)
        for size in range(2, campaign.subject.causes + 1):
            if not solved(gaps, contest[0]):
                contest = _combine(contest, size, gaps, without, tell)
        contest = _simpler(contest, gaps)
    best = choose(contest, gaps)
    if best and before <= QUIET and not _sure(metric, nominal, best):
        best = None
    share = closure(metric, nominal, best.fit.residual if best else nominal, campaign.held_out)
    verdict = "unexplained" if best or before > HEALTHY else "consistent"
    ties: tuple[Judged, ...] = ()
    if best and explains(gaps, best, share):
        rivals = (j for j in contest if j is not best and solved(gaps, j))
        ties = tuple(j for j in rivals if _ties(metric, best, j, before))
        verdict = "ambiguous" if ties else "explained"
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
        others = climb(own, candidate)
        if metric.campaign.subject.swings:
            others.append(fit(beside(slow, candidate.effects), candidate, START).coordinates)
        return judge(own, fit(own, candidate, others=others))

    with ThreadPoolExecutor(max(1, len(candidates))) as threads:
        return _best_of_each(threads.map(judged, candidates))


def _best_of_each(found: Iterable[Judged]) -> list[Judged]:
    """Of those with the same causes at the same places the best, best first."""
    best: dict[tuple, Judged] = {}
    for judged in sorted(found, key=lambda j: j.held_out):
        best.setdefault(judged.fit.candidate.places, judged)
    return list(best.values())


def solved(nominal: Gaps, found: Judged) -> bool:
    """Whether an explanation leaves no more than noise and its own inaccuracy, learnt from and held out."""
    slack = found.metric.campaign.subject.slack
    return all(after <= SETTLED + slack * (before - 1) for before, after in zip(nominal, found.gaps))


def explains(nominal: Gaps, found: Judged, share: Closure) -> bool:
    """Whether an explanation leaves no more than that and may have closed the whole gap."""
    return solved(nominal, found) and share.high > WHOLE


def _sure(metric: Metric, nominal: Array, found: Judged) -> bool:
    """Whether the held-out residual is smaller than the nominal one beyond what chance does."""
    fall, error = worse_by(metric, found.fit.residual, nominal, metric.campaign.held_out)
    return fall > SURE * error


def _combine(
    contest: list[Judged], size: int, nominal: Gaps, without: Sequence[str], tell: Callable[[str], None]
) -> list[Judged]:
    """Forward, with a swap: partners for the leader, others for its best partner, then for the next leader."""
    leaders = [j for j in contest if len(j.fit.effects) == size - 1 and j.held_out < 1 + HOPE * (nominal[1] - 1)]
    trunks = [(leader.metric, leader.fit.effects) for leader in leaders[:LEADERS]]
    before, first = contest[0].gaps, True
    saving = contest[0].metric.campaign.subject.swings  # where all is soon tried a tie is worth the look
    while trunks and not (saving and solved(nominal, contest[0])):
        metric, trunk = trunks.pop(0)
        tell("screening beside " + Candidate(trunk).label)
        tried = {judged.fit.candidate.places for judged in contest}
        pairs = [*_partnered(metric, trunk, without), *_shared(trunk, contest)]
        pairs = [pair for pair in pairs if pair.places not in tried]
        tell("combinations: " + ", ".join(dict.fromkeys(pair.label for pair in pairs)))
        found = _polished(_fit_all(metric, pairs), before, tell)
        contest = sorted([*contest, *found], key=lambda j: j.held_out)
        if first and len(contest[0].fit.effects) == size:
            trunks.insert(0, (contest[0].metric, contest[0].fit.effects[1:]))
        first = False
    return contest


def _partnered(metric: Metric, trunk: tuple[Effect, ...], without: Sequence[str]) -> list[Candidate]:
    """Effects together with what screening about their machine suggests."""
    raw = metric.residual(*metric.predict([trunk]))
    kinds, lines = everywhere(metric.campaign.subject, without), spectral_lines(metric, metric.clean(raw))
    partners = Signatures(metric, kinds, lines, trunk).rank(raw)[:SECONDS]
    return [Candidate((*trunk, *start.effects)) for partner in partners for start in partner.starts]


def _shared(trunk: tuple[Effect, ...], contest: Sequence[Judged]) -> list[Candidate]:
    """Effects together with the best of those that do not share a cause with them: each may stand for part of both."""
    taken = {cause for effect in trunk for cause in causes(type(effect), effect.location)}
    alone = [j.fit.effects[0] for j in contest if len(j.fit.effects) == 1]
    free = [effect for effect in alone if not taken & causes(type(effect), effect.location)]
    return [Candidate((*trunk, effect)) for effect in free[:RUNNERS]]


def _simpler(contest: list[Judged], nominal: Gaps) -> list[Judged]:
    """The contest, and what remains of its leader with one effect or some knobs less, as long as that is chosen."""
    leader: Judged | None = contest[0]
    while leader:
        known = {j.fit.candidate.places: j.held_out for j in reversed(contest)}
        parts = _fit_all(leader.metric, list(Candidate(leader.fit.effects).simpler()))
        for part in sorted(parts, key=lambda j: len(j.fit.coordinates)):
            before = known.get(part.fit.candidate.places, np.inf)
            if part.held_out < min(CLOSE * leader.held_out, HELPED * before):
                part = _polish(part, nominal)
            if part.held_out < HELPED * before:
                contest = _best_of_each([*contest, part])
                if choose(contest, nominal) is part:
                    break
        chosen = choose(contest, nominal)
        leader = chosen if chosen and len(chosen.fit.coordinates) < len(leader.fit.coordinates) else None
    return contest


def _polished(contest: Sequence[Judged], nominal: Gaps, tell: Callable[[str], None]) -> list[Judged]:
    """Those that are worth it fitted again.

    They come close to the best and leave less than almost all that there was, or have learnt so well that what they say
    of recordings held out may be a matter of sizes that those learnt from hardly tell.
    """
    enough, learnt = 1 + HOPE * (nominal[1] - 1), near(nominal[0])
    close = [j for j in contest if j.held_out < min(CLOSE * contest[0].held_out, enough)][:LEADERS]
    close += [j for j in sorted(contest, key=lambda j: j.train)[:1] if j not in close and j.train < learnt]
    polished: list[Judged] = []
    for judged in close:
        behind = judged.held_out - close[0].held_out > RIVAL * (nominal[1] - 1)
        if polished and behind and solved(nominal, polished[0]):
            polished.append(judged)
            continue
        polished.append(_polish(judged, nominal))
        tell(f"{judged.label} fitted again: held-out gap {judged.held_out:.2f} -> {polished[-1].held_out:.2f}")
    return sorted([*polished, *(j for j in contest if j not in close)], key=lambda j: j.held_out)


def near(gap: float) -> float:
    """Up to where most of a gap is gone."""
    return max(QUIET, 1 + FAR * (gap - 1))


def _polish(judged: Judged, nominal: Gaps) -> Judged:
    """Fit again from where the last fit has led, then with the nuisances and model error there, until it stays."""
    for number in range(1 + ROUNDS):
        metric, effects = judged.metric, judged.fit.effects
        estimate = metric.estimate(metric.residual(*metric.predict([effects])))
        metric, swings = (around if number else anchored)(metric, effects, estimate), metric.campaign.subject.swings
        if number and swings:
            again = judge(*settle(metric, Candidate(effects)))
        else:
            again = judge(metric, fit(metric, Candidate(effects), ROUGH if swings else SHARP))
        if again.train > WORSE * judged.train:
            break
        moved, helped = np.abs(again.fit.coordinates - judged.fit.coordinates), again.train < HELPED * judged.train
        judged, stays = again, number and np.all(moved < np.maximum(NEAR, again.deviation))
        hopeless = swings and not helped and again.train > near(nominal[0])
        if hopeless or (stays and not (helped and max(again.gaps) > SETTLED)):
            break
    return judged


def choose(contest: Sequence[Judged], nominal: Gaps) -> Judged | None:
    """The best single cause, of those that suffice if any do, with few knobs, or more causes where each is worth it."""
    before = nominal[1]
    useful = [j for j in contest if before**2 - j.held_out**2 > SMALLEST]
    singles = [j for j in useful if len(j.fit.effects) == 1]
    singles = [j for j in singles if solved(nominal, j)] or singles
    best = min(singles, key=_price, default=None)
    best = _simplest(best, singles, before)
    for size in range(2, 1 + max((len(j.fit.effects) for j in useful), default=0)):
        best = _with_more(best, [j for j in useful if len(j.fit.effects) == size], contest, before)
    return best


def _price(found: Judged) -> float:
    """The held-out gap, dearer with every knob: of explanations that say the same the simplest is the best."""
    return found.held_out * (1 + KNOB * len(found.fit.coordinates))


def _with_more(
    best: Judged | None, larger: Sequence[Judged], contest: Sequence[Judged], before: float
) -> Judged | None:
    """The best explanation with one more cause, where it closes its share of what is left, or the best so far."""
    for judged in sorted(larger, key=_price):
        members = [j for j in contest if set(j.fit.candidate.places) < set(judged.fit.candidate.places)]
        alone = min([before, *(j.held_out for j in members), *([best.held_out] if best else [])])
        gain = alone**2 - judged.held_out**2
        subject = judged.metric.campaign.subject
        inaccurate = 0.0 if max(judged.gaps) < FLOOR else subject.spill * (before**2 - alone**2)
        enough = gain > SMALLEST + inaccurate
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
