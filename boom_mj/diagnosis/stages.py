"""The contest: single causes, then combinations, fitted roughly, and the leaders again about the machine they make."""

from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from boom_mj.diagnosis.candidate import Candidate, apart, everywhere
from boom_mj.diagnosis.decision import QUIET, SETTLED, Gaps, choose, complete, solved, useful
from boom_mj.diagnosis.fitting import ROUGH, SHARP, START, climb, fit, settle
from boom_mj.diagnosis.linearisation import Metric, anchored, around, beside, blurred, coarsely
from boom_mj.diagnosis.scoring import Scored, across, judge
from boom_mj.diagnosis.screening import Screened, Signatures, spectral_lines
from boom_mj.effects import Effect

FINALISTS = 6  # singles that are fitted
SECONDS, RUNNERS = 3, 2  # partners that are tried: of those screened beside a leader, of those fitted without it
LEADERS = 2  # of a contest that are fitted again
HIDDEN = 0.5  # of what a leader that suffices leaves beyond noise, what screening must promise of a second cause
ROUNDS, WORSE = 3, 1.2  # of polishing, and the growth of the training gap at which it is given up
HELPED, FAR = 0.98, 0.25  # of a gap that fitting again must leave to go on, if more than this of the gap is left
NEAR = 0.1  # of a size worth finding, within which nuisances and model error stay what they are
HOPE = 0.9  # of what there was to explain: what leaves more is not fitted again
CLOSE = 1.5  # times the best held-out gap, up to which a rival is fitted again
RIVAL = 0.1  # of what there was to explain, up to which it is even where the best suffices


def singles(metric: Metric, screened: Sequence[Screened], tell: Callable[[str], None]) -> list[Scored]:
    """The best few of a screening, fitted and judged, best first."""
    tell("contest of " + ", ".join(s.candidate.label for s in screened[:FINALISTS]))
    return _fit_all(metric, [start for s in shortlist(screened) for start in s.starts])


def refined(contest: list[Scored], nominal: Gaps, tell: Callable[[str], None]) -> list[Scored]:
    """A contest of single causes whose leaders are fitted again, and simplified where that suffices."""
    contest = _polished(contest, nominal, tell)
    return _simpler(contest, nominal) if solved(nominal, contest[0]) else contest


def combined(contest: list[Scored], nominal: Gaps, without: Sequence[str], tell: Callable[[str], None]) -> list[Scored]:
    """A contest that single causes do not decide, or that one decides which may hide another, simplified."""
    for size in range(2, contest[0].metric.campaign.subject.causes + 1):
        if not solved(nominal, contest[0]):
            contest = _combine(contest, size, nominal, without, tell)
        elif len(contest[0].fit.effects) == size - 1 and not complete(nominal, contest[0]):
            contest = _revealed(contest, without, tell)
    return _simpler(contest, nominal)


def shortlist(screened: Sequence[Screened]) -> list[Screened]:
    """The best few, and the best of each kind that explains a share worth a rollout."""
    chosen = list(screened[:FINALISTS])
    kinds = {s.candidate.effects[0].id for s in chosen}
    for s in screened[FINALISTS:]:
        if s.candidate.effects[0].id not in kinds and s.share > 0.3 * screened[0].share and len(chosen) < FINALISTS + 3:
            chosen.append(s)
            kinds.add(s.candidate.effects[0].id)
    return chosen


def _fit_all(metric: Metric, candidates: Sequence[Candidate]) -> list[Scored]:
    coarse = coarsely(metric)
    slow = blurred(coarse)

    def judged(candidate: Candidate) -> Scored:
        own = beside(coarse, candidate.effects)
        others = climb(own, candidate)
        if metric.campaign.subject.swings:
            others.append(fit(beside(slow, candidate.effects), candidate, START).coordinates)
        return judge(own, fit(own, candidate, others=others))

    with ThreadPoolExecutor(max(1, len(candidates))) as threads:
        return _best_of_each(threads.map(judged, candidates))


def _best_of_each(found: Iterable[Scored]) -> list[Scored]:
    """Of those with the same causes at the same places the best, best first."""
    best: dict[tuple, Scored] = {}
    for judged in sorted(found, key=lambda j: j.held_out):
        best.setdefault(judged.fit.candidate.places, judged)
    return list(best.values())


def _combine(
    contest: list[Scored], size: int, nominal: Gaps, without: Sequence[str], tell: Callable[[str], None]
) -> list[Scored]:
    """Forward, with a swap: partners for the leader, others for its best partner, then for the next leader."""
    leaders = [j for j in contest if len(j.fit.effects) == size - 1 and useful(j, nominal)]
    trunks = [(leader.metric, leader.fit.effects) for leader in leaders[:LEADERS]]
    before, first = contest[0].gaps, True
    saving = contest[0].metric.campaign.subject.swings  # where all is soon tried a tie is worth the look
    while trunks and not (saving and solved(nominal, contest[0])):
        metric, trunk = trunks.pop(0)
        contest = _paired(contest, metric, trunk, _partners(metric, trunk, without, tell), before, tell)
        if first and len(contest[0].fit.effects) == size:
            trunks.insert(0, (contest[0].metric, contest[0].fit.effects[1:]))
        first = False
    return contest


def _revealed(contest: list[Scored], without: Sequence[str], tell: Callable[[str], None]) -> list[Scored]:
    """The contest, and pairs of a leader that suffices, where screening promises much of what it leaves."""
    leader = contest[0]
    metric, trunk, square = leader.metric, leader.fit.effects, leader.train**2
    partners = _partners(metric, trunk, without, tell)
    if max((partner.share for partner in partners), default=0.0) * square < HIDDEN * (square - 1):
        return contest
    return _paired(contest, metric, trunk, partners, leader.gaps, tell)


def _partners(
    metric: Metric, trunk: tuple[Effect, ...], without: Sequence[str], tell: Callable[[str], None]
) -> list[Screened]:
    """What screening suggests about the machine that effects make."""
    tell("screening beside " + Candidate(trunk).label)
    raw = metric.residual(*metric.predict([trunk]))
    kinds, lines = everywhere(metric.campaign.subject, without), spectral_lines(metric, metric.clean(raw))
    return Signatures(metric, kinds, lines, trunk).rank(raw)[:SECONDS]


def _paired(
    contest: list[Scored],
    metric: Metric,
    trunk: tuple[Effect, ...],
    partners: Sequence[Screened],
    before: Gaps,
    tell: Callable[[str], None],
) -> list[Scored]:
    """The contest, and effects together with partners and with what does well without them."""
    tried = {judged.fit.candidate.places for judged in contest}
    pairs = [Candidate((*trunk, *start.effects)) for partner in partners for start in partner.starts]
    pairs = [pair for pair in (*pairs, *_shared(trunk, contest)) if pair.places not in tried]
    tell("combinations: " + ", ".join(dict.fromkeys(pair.label for pair in pairs)))
    found = _polished(_fit_all(metric, pairs), before, tell)
    return sorted([*contest, *found], key=lambda j: j.held_out)


def _shared(trunk: tuple[Effect, ...], contest: Sequence[Scored]) -> list[Candidate]:
    """Effects together with the best of those that do not share a cause with them: each may stand for part of both."""
    alone = [j.fit.effects[0] for j in contest if len(j.fit.effects) == 1]
    free = [effect for effect in alone if apart(type(effect), effect.location, trunk)]
    return [Candidate((*trunk, effect)) for effect in free[:RUNNERS]]


def _simpler(contest: list[Scored], nominal: Gaps) -> list[Scored]:
    """The contest, and what remains of its leader with one effect or some knobs less, as long as that is chosen."""
    leader: Scored | None = contest[0]
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


def _polished(contest: Sequence[Scored], nominal: Gaps, tell: Callable[[str], None]) -> list[Scored]:
    """Those that are worth it fitted again.

    They come close to the best and leave less than almost all that there was, or have learnt so well that what they say
    of recordings held out may be a matter of sizes that those learnt from hardly tell.
    """
    enough, learnt = 1 + HOPE * (nominal[1] - 1), near(nominal[0])
    close = [j for j in contest if j.held_out < min(CLOSE * contest[0].held_out, enough)][:LEADERS]
    close += [j for j in sorted(contest, key=lambda j: j.train)[:1] if j not in close and j.train < learnt]
    polished: list[Scored] = []
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


def _polish(judged: Scored, nominal: Gaps) -> Scored:
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
    return across(judged, nominal[0])
