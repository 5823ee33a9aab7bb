"""Which explanation is chosen, whether it suffices, and which rivals the data cannot tell from it."""

from collections.abc import Sequence

import numpy as np

from boom_mj.diagnosis.linearisation import Linearisation
from boom_mj.diagnosis.scoring import Scored, correlated
from boom_mj.estimation.bootstrap import Closure, log_squares, mean_over, worse_by
from boom_mj.estimation.intervals import FEWEST, robust_variance
from boom_mj.estimation.least_squares import OPTIONS

Array = np.ndarray
Gaps = tuple[float, float]  # training, held out


def solved(as_built: Gaps, found: Scored) -> bool:
    """Whether an explanation leaves no more than noise and its own inaccuracy, in training and held out."""
    return all(after <= found.model.criteria.enough(before) for before, after in zip(as_built, found.gaps))


def leaps(found: Scored, before: Gaps) -> bool:
    """Whether one more cause has closed half of what was left above noise, in training and held out."""
    left = 1 - found.model.budget.leap
    return all(after - 1 < left * (there - 1) for after, there in zip(found.gaps, before))


def useful(found: Scored, as_built: Gaps) -> bool:
    """Whether it takes away more than the least that counts, in training and held out."""
    falls = (before**2 - after**2 for before, after in zip(as_built, found.gaps))
    return min(falls) > found.model.criteria.least_gain


def explains(as_built: Gaps, found: Scored, share: Closure) -> bool:
    """Whether an explanation leaves no more than that and may have closed the whole gap."""
    return solved(as_built, found) and share.high > found.model.criteria.whole_closure


def held_out_loss(model: Linearisation, better: Array, worse: Array) -> tuple[float, float]:
    """By how much a residual (N,) is worse than another in what is held out, and the standard error of that.

    In mean squares, or, where `gain_z` decides, in mean logarithms of them (`estimation.bootstrap.log_squares`).
    """
    data, rows = model.data, model.data.held_out
    if not model.criteria.gain_z:
        return worse_by(data.windows[rows], better[rows], worse[rows])
    cells, windows = log_squares(data, np.array([better, worse]))
    # of few segments, and of motions that repeat, windows are not independent
    clusters = [data.recording_of, *([data.moments(model.facts.repeat_s)] if model.facts.repeat_s else [])]
    first = np.unique(data.windows[rows], return_index=True)[1]
    alike = [cluster[rows][first][windows] for cluster in clusters]
    losses = [mean_over(c, cells[1] - cells[0]) for c in (windows, *(c for c in alike if len(np.unique(c)) >= FEWEST))]
    return losses[0][0], max(error for _, error in losses)


def sure(without: Array, found: Scored) -> bool:
    """Whether held-out data tell by themselves, beyond what chance does, that what an explanation predicts is there.

    A prediction d leaves r of y = r + d; y = a d has a = d^T y / d^T d, whose deviation is that of d^T r over windows.

    Args:
        without: residual of the machine as built, or of an explanation with less causes, (N,).
    """
    model, left = found.model, found.fit.residual
    rows = model.data.held_out
    predicted = (without - left)[rows, None].astype(float)
    if not np.any(predicted):
        return False
    inverse = np.linalg.inv(predicted.T @ predicted)
    (amplitude,) = inverse @ predicted.T @ without[rows]
    (variance,) = robust_variance(inverse, predicted * left[rows, None], correlated(model, rows))
    return bool(amplitude > model.criteria.sure_z * np.sqrt(variance))


def choose(scored: Sequence[Scored], as_built: Gaps) -> Scored | None:
    """The best single cause, of those that suffice if any do, with few parameters, or more causes, each worth it."""
    helpful = [j for j in scored if useful(j, as_built)]
    if helpful and helpful[0].model.criteria.gain_z:
        return _within_error(helpful)
    singles = [j for j in helpful if len(j.fit.effects) == 1]
    singles = [j for j in singles if solved(as_built, j)] or singles
    best = min(singles, key=_price, default=None)
    best = _simplest(best, singles, as_built)
    for size in range(2, 1 + max((len(j.fit.effects) for j in helpful), default=0)):
        best = _with_more(best, [j for j in helpful if len(j.fit.effects) == size], scored, as_built)
    return best


def _within_error(scored: Sequence[Scored]) -> Scored:
    """The simplest explanation that is no worse than the best by more than its standard error, or leaves as little.

    What training tells apart few held-out windows need not (`Scored.rivals`). One of likely sizes goes before one of
    unlikely ones (`Scored.doubt`), one whose effects all surely do something before any other: of two that do each
    other's part no size is known.
    """
    scored = converged(scored)
    scored = [j for j in scored if all(map(j.shows, j.fit.effects))] or scored
    criteria, data = scored[0].model.criteria, scored[0].model.data
    logs = log_squares(data, np.array([j.fit.residual for j in scored]))[0].mean(axis=1) + [j.doubt for j in scored]
    price = {id(j): log + criteria.parameter_cost * len(j.fit.scaled) for j, log in zip(scored, logs)}

    def near(best: Scored, z: float) -> list[Scored]:
        losses = [held_out_loss(best.model, best.fit.residual, j.fit.residual) for j in scored]
        equal = [abs(j.held_out**2 - best.held_out**2) < criteria.least_gain for j in scored]
        alike = [same or loss <= z * error for (loss, error), same in zip(losses, equal)]
        return [j for j, so in zip(scored, alike) if so and j.rivals(best)]

    best = min(scored, key=lambda j: price[id(j)])
    alike = [j for j in near(best, criteria.gain_z) if j.plausible or not best.plausible]
    return min(alike, key=lambda j: (len(j.fit.effects), len(j.fit.scaled), price[id(j)]), default=best)


def converged(scored: Sequence[Scored]) -> list[Scored]:
    """Those that fit training no worse than any that they contain, and of whose effects none came out neutral.

    Of others it is chance what they say held out.
    """

    def worse(found: Scored, part: Scored) -> bool:
        contains = set(part.fit.candidate.places) < set(found.fit.candidate.places)
        return contains and found.train**2 > (1 + OPTIONS.rough) * part.train**2

    ended = [j for j in scored if not any(worse(j, one) for one in scored)]
    return [j for j in ended if all(np.any(at) for at in j.by_effect(j.fit.scaled))] or ended


def _price(found: Scored) -> float:
    """The held-out gap, dearer with every parameter: of explanations that say the same the simplest is the best."""
    return found.held_out * (1 + found.model.criteria.parameter_cost * len(found.fit.scaled))


def _with_more(
    best: Scored | None, larger: Sequence[Scored], scored: Sequence[Scored], as_built: Gaps
) -> Scored | None:
    """The best explanation with one more cause, where it closes its share of what is left, or the best so far.

    What is left may be the inaccuracy of what there is (`leakage`), unless it is more than an explanation may leave and
    with one more cause it is not.
    """
    before = as_built[1]
    for found in sorted(larger, key=_price):
        members = [j for j in scored if set(j.fit.candidate.places) < set(found.fit.candidate.places)]
        fewer = [*members, *([best] if best else [])]
        alone = min([before, *(j.held_out for j in fewer)])
        gain, criteria = alone**2 - found.held_out**2, found.model.criteria
        needs = solved(as_built, found) and not any(solved(as_built, j) for j in fewer)
        exact = needs or max(found.gaps) < criteria.floor
        inaccurate = 0.0 if exact else criteria.leakage * (before**2 - alone**2)
        enough = gain > criteria.least_gain + inaccurate and all(sure(one.fit.residual, found) for one in members)
        if enough and alone - found.held_out > criteria.required_gain * (alone - 1):
            return _simplest(found, larger, as_built)
    return best


def _simplest(best: Scored | None, rivals: Sequence[Scored], as_built: Gaps) -> Scored | None:
    """The same causes with fewer parameters, where the others do not close their share of what those leave.

    What suffices is simplified only to what suffices.
    """
    for found in rivals:
        if best and nested(found, best) and solved(as_built, found) >= solved(as_built, best):
            criteria = found.model.criteria
            loss = found.held_out**2 - best.held_out**2
            share = criteria.required_gain * (found.held_out - 1)
            same = [e.id for e in found.fit.effects] == [e.id for e in best.fit.effects]
            if same and criteria.leakage:
                best = found if loss < criteria.leakage * as_built[1] ** 2 else best
            elif loss < criteria.least_gain or found.held_out - best.held_out < share:
                best = found
    return best


def ties_with(model: Linearisation, best: Scored, other: Scored, before: float) -> bool:
    """Whether a rival does as well within its uncertainty; supersets of the best do not count.

    Where `gain_z` decides, one of unlikely sizes has to do better than one of likely ones (`Scored.doubt`).
    """
    if set(best.fit.candidate.places) <= set(other.fit.candidate.places):
        return False
    if nested(best, other) or len(other.fit.effects) > len(best.fit.effects):
        return False
    worse, error = held_out_loss(model, best.fit.residual, other.fit.residual)
    criteria = model.criteria
    worse += other.doubt - best.doubt if criteria.gain_z else 0.0
    close = other.held_out - best.held_out < criteria.tie_closure * (before - min(best.held_out, 1.0))
    return close and worse < criteria.tie_z * error


def nested(best: Scored, other: Scored) -> bool:
    """Whether the rival is the same effects, or what has them as special cases, with more freedom."""
    pairs = list(zip(best.fit.effects, other.fit.effects))
    alike = len(best.fit.effects) == len(other.fit.effects) and all(
        a.id == b.id or a.id in b.special_cases for a, b in pairs
    )
    return alike and len(other.fit.scaled) > len(best.fit.scaled)
