"""Which explanation of a contest is chosen, whether it suffices, and which rivals the data cannot tell from it."""

from collections.abc import Sequence

import numpy as np

from boom_mj.diagnosis.linearisation import Metric
from boom_mj.diagnosis.scoring import Closure, Scored, worse_by

Array = np.ndarray
Gaps = tuple[float, float]  # learnt from, held out
QUIET, SURE = 1.15, 4.0  # held-out gap up to which a cause must be sure, and in how many standard errors
SMALLEST = 0.10  # fall of the held-out mean square that counts
FLOOR = 1.0  # gap of noise alone: an effect's own inaccuracy is not what another one closes down to it
SETTLED = 1.03  # gap that an explanation may leave, held out or not; right ones leave 0.95 to 1.01
WHOLE = 0.95  # closure that the interval of an explanation must reach
KNOB = 1e-3  # of the held-out gap, what a knob must be worth
TIE = 0.03  # closure within which rivals tie


def solved(nominal: Gaps, found: Scored) -> bool:
    """Whether an explanation leaves no more than noise and its own inaccuracy, learnt from and held out."""
    slack = found.metric.campaign.subject.slack
    return all(after <= SETTLED + slack * (before - 1) for before, after in zip(nominal, found.gaps))


def complete(nominal: Gaps, found: Scored) -> bool:
    """Whether an explanation suffices and leaves so little that no other cause hides in it."""
    return solved(nominal, found) and max(found.gaps) < found.metric.campaign.subject.hides


def useful(found: Scored, nominal: Gaps) -> bool:
    """Whether it takes away more of what is held out than the least that counts."""
    return nominal[1] ** 2 - found.held_out**2 > SMALLEST


def explains(nominal: Gaps, found: Scored, share: Closure) -> bool:
    """Whether an explanation leaves no more than that and may have closed the whole gap."""
    return solved(nominal, found) and share.high > WHOLE


def sure(metric: Metric, nominal: Array, found: Scored) -> bool:
    """Whether the held-out residual is smaller than the nominal one beyond what chance does."""
    fall, error = worse_by(metric, found.fit.residual, nominal, metric.campaign.held_out)
    return fall > SURE * error


def choose(contest: Sequence[Scored], nominal: Gaps) -> Scored | None:
    """The best single cause, of those that suffice if any do, with few knobs, or more causes where each is worth it."""
    before = nominal[1]
    helpful = [j for j in contest if useful(j, nominal)]
    singles = [j for j in helpful if len(j.fit.effects) == 1]
    singles = [j for j in singles if solved(nominal, j)] or singles
    best = min(singles, key=_price, default=None)
    best = _simplest(best, singles, before)
    for size in range(2, 1 + max((len(j.fit.effects) for j in helpful), default=0)):
        best = _with_more(best, [j for j in helpful if len(j.fit.effects) == size], contest, before)
    return best


def _price(found: Scored) -> float:
    """The held-out gap, dearer with every knob: of explanations that say the same the simplest is the best."""
    return found.held_out * (1 + KNOB * len(found.fit.coordinates))


def _with_more(
    best: Scored | None, larger: Sequence[Scored], contest: Sequence[Scored], before: float
) -> Scored | None:
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


def _simplest(best: Scored | None, rivals: Sequence[Scored], before: float) -> Scored | None:
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


def ties_with(metric: Metric, best: Scored, other: Scored, before: float) -> bool:
    """Whether a rival does as well within its uncertainty; supersets of the best do not count."""
    if set(best.fit.candidate.places) <= set(other.fit.candidate.places):
        return False
    if _nested(best, other) or len(other.fit.effects) > len(best.fit.effects):
        return False
    worse, error = worse_by(metric, best.fit.residual, other.fit.residual, metric.campaign.held_out)
    return (other.held_out - best.held_out) < TIE * (before - 1) and worse < 2 * error


def _nested(best: Scored, other: Scored) -> bool:
    """Whether the rival is the same effects, or what has them as special cases, with more freedom."""
    pairs = list(zip(best.fit.effects, other.fit.effects))
    alike = len(best.fit.effects) == len(other.fit.effects) and all(
        a.id == b.id or a.id in b.special_cases for a, b in pairs
    )
    return alike and len(other.fit.coordinates) > len(best.fit.coordinates)
