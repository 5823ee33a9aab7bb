"""The budget of a gap: what each cause takes of it, and how sure each explanation is, from held-out scores by windows.

Shares are of the held-out mean square of the machine as built, v(nothing). With v(T) the mean square of the effects T
alone at their sizes, nuisances estimated anew, a cause's share is its Shapley value of v(nothing) - v(T): the mean over
all orders of adding, so that shares, remainder v(all) - 1 and floor 1 add up to the whole. All v(T) are whitened and
cleaned of nuisances alike, as the explanation is: differences of another noise model would pass for shares.

Windows are resampled as wholes. In every draw one of these is true: the machine as built needs no explanation, an
explanation suffices and is the cheapest, or none suffices. How often each is true, with what is known of how often
explanations deceive (`odds`), is its probability; raw likelihoods of many correlated samples would make every wrong
name certain.
"""

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from math import factorial

import numpy as np

from boom_mj.diagnosis.candidate import apart
from boom_mj.diagnosis.decision import converged
from boom_mj.diagnosis.linearisation import Linearisation
from boom_mj.diagnosis.scoring import Scored
from boom_mj.effects import Effect
from boom_mj.estimation.bootstrap import log_squares, resampled_means
from boom_mj.estimation.intervals import TAIL
from boom_mj.systems.system import Hypothesis

Array = np.ndarray
MOST_SUBSETS = 32  # of effects that are simulated for shares; more effects are added in turn, each first and last once


@dataclass(frozen=True)
class Share:
    """Of the held-out mean square of the machine as built, with a 95 % interval."""

    value: float
    low: float
    high: float


@dataclass(frozen=True)
class Budget:
    """Shares of the effects in their order, of what is left above the floor, and of the floor; they add up to 1."""

    shares: tuple[Share, ...]
    remainder: Share
    floor: Share


@dataclass(frozen=True)
class Odds:
    """Probabilities that, but for the last, add up to 1.

    Attributes:
        explanations: of every scored one.
        outside_library: of something that the library does not hold.
        none: of nothing.
        combination: of effects of the library that were not found together.
        hidden: of causes besides those of an explanation that the recordings do not show.
        unwell: of such causes where nothing needs an explanation.
    """

    explanations: tuple[float, ...]
    outside_library: float
    none: float
    combination: float = 0.0
    hidden: float = 0.0
    unwell: float = 0.0


def gap_budget(best: Scored) -> Budget:
    """What the effects of an explanation take of the gap as built."""
    model, effects, seen = best.model, best.fit.effects, metric(best.model)
    *others, whole = subsets_of(len(effects))
    alone = [tuple(effects[k] for k in subset) for subset in others]
    residuals = [seen(some).clean(seen(some).residual(said)) for some, said in zip(alone, model.predict(alone))]
    squares = _mean_squares(model, [*residuals, best.fit.residual])  # (draws + 1, subsets)
    at = {subset: k for k, subset in enumerate([*others, whole])}
    before, after = squares[:, at[()]], squares[:, at[whole]]
    shares = [_share(shapley(squares, at, k, len(effects)) / before) for k in range(len(effects))]
    return Budget(tuple(shares), _share((after - 1) / before), _share(1 / before))


def metric(model: Linearisation) -> Callable[[Hypothesis], Linearisation]:
    """What counts as a difference beside some of a model's effects: without a wind there are no gusts."""
    calm = model if model.latent is None else model.with_noise(model.noise.plain)
    return lambda effects: model if any(effect.basis(0.0) for effect in effects) else calm


def odds(
    as_built: Array,
    scored: Sequence[Scored],
    model: Linearisation,
    mimicked: Sequence[float] | None = None,
    unseen: float = 1.0,
) -> Odds:
    """How often each explanation is the right one when held-out windows are drawn anew.

    An explanation that suffices may do what an effect outside the library does, and one that is not found may be of
    effects of the library: with o, f and m the criteria `outside`, `fooled` and `missed`, and k what is mimicked,

        P(outside | explained) = o (f + k) / (o (f + k) + (1 - o) (1 - m)),
        P(outside | unexplained) = o (1 - f) / (o (1 - f) + (1 - o) m).

    Whatever is said, causes that these recordings do not show may be there as well: by Poisson's law one or more with
    probability 1 - exp(-l u), with u the unseen share and l the criterion `further`, of healthy machines `unwell`.

    Args:
        mimicked: how many of the library's other effects each explanation does as well on these data, up to one: so
            likely is it that it does what an unknown one does; none if left out.
        unseen: share of the library's effects that these recordings do not show; all if left out.
    """
    criteria = model.criteria
    unshown = [1 - float(np.exp(-causes * unseen)) for causes in (criteria.further, criteria.unwell)]
    gaps = np.sqrt(_mean_squares(model, [as_built, *(one.fit.residual for one in scored)])[1:])
    before, after = gaps[:, 0], gaps[:, 1:]
    count, outside = len(gaps), criteria.outside
    unknown = outside * (1 - criteria.fooled)
    unknown /= unknown + (1 - outside) * criteria.missed
    if not scored:
        healthy = float(np.mean(before <= criteria.healthy_gap))
        return Odds((), unknown * (1 - healthy), healthy, (1 - unknown) * (1 - healthy), *unshown)
    right = _right(scored, after, after <= criteria.enough(before)[:, None])
    suffices = right.any(axis=1)
    fall = before**2 - after.min(axis=1) ** 2
    none = (before <= criteria.healthy_gap) & (fall <= criteria.least_gain)
    chosen = right[~none].sum(axis=0) / count
    alike = outside * (criteria.fooled + (np.zeros(len(scored)) if mimicked is None else np.minimum(mimicked, 1.0)))
    alike = alike / (alike + (1 - outside) * (1 - criteria.missed))
    left = float(np.mean(~suffices & ~none))
    return Odds(
        tuple(map(float, chosen * (1 - alike))),
        float(chosen @ alike) + unknown * left,
        float(np.mean(none)),
        (1 - unknown) * left,
        *unshown,
    )


def _right(scored: Sequence[Scored], after: Array, suffices: Array) -> Array:
    """Which explanation is the right one in every draw, (draws, explanations): of those that suffice the cheapest.

    Where `gain_z` decides, all that leave as little (`least_gain`) by as few causes are right alike: of what a machine
    has a little, no model tells.
    """
    criteria = scored[0].model.criteria
    if not criteria.gain_z:
        price = after * (1 + criteria.parameter_cost * np.array([len(one.fit.scaled) for one in scored]))
        return np.eye(len(scored))[np.argmin(np.where(suffices, price, np.inf), axis=1)] * suffices
    squares = np.where(suffices, after**2, np.inf)
    close = suffices & (squares <= squares.min(axis=1, keepdims=True) + criteria.least_gain)
    causes = np.where(close, [len(one.fit.effects) for one in scored], np.inf)
    right = close & (causes == causes.min(axis=1, keepdims=True))
    return right / np.maximum(right.sum(axis=1, keepdims=True), 1)


def inclusion(found: Odds, scored: Sequence[Scored], effect: Effect) -> float:
    """Probability of the explanations that hold a cause."""
    return float(sum(p for p, one in zip(found.explanations, scored) if effect.cause in one.fit.candidate.places))


def needed(best: Scored, scored: Sequence[Scored], as_built: Array, effect: Effect) -> bool:
    """Whether whatever does without a cause leaves much more, in 95 of 100 draws: so sure is it, whatever is left.

    A cause that by the intervals of its sizes may do nothing is not. Explanations that hold a special case of it, or of
    which it is one, do not do without it. Where the floor is never reached, what fits training much worse is no
    rival (`Scored.rivals`).
    """
    model = best.model
    if not best.shows(effect):
        return False
    rivals = scored
    if model.criteria.gain_z:
        rivals = [one for one in converged(scored) if one.rivals(best)]
    others = [one for one in rivals if apart(type(effect), effect.site, one.fit.effects)]
    if model.criteria.gain_z:
        residuals = [best.fit.residual, as_built, *(one.fit.residual for one in others)]
        cells, windows = log_squares(model.data, np.array(residuals))
        scores = resampled_means(windows, cells) + np.array([best.doubt, 0.0, *(one.doubt for one in others)])
        return bool(np.quantile((scores[:, 1:].min(axis=1) - scores[:, 0])[1:], TAIL) > 0)
    squares = _mean_squares(model, [best.fit.residual, as_built, *(one.fit.residual for one in others)])
    rival = squares[:, 1:].min(axis=1)
    closes = (rival - squares[:, 0]) / np.maximum(rival - 1, 1e-9)
    return bool(np.quantile(closes[1:], TAIL) > model.criteria.named_closure)


def any_needed(best: Scored, scored: Sequence[Scored], as_built: Array) -> bool:
    """Whether nothing else does what one of the causes does."""
    return any(needed(best, scored, as_built, effect) for effect in best.fit.effects)


def _mean_squares(model: Linearisation, residuals: Sequence[Array]) -> Array:
    """Held-out mean squares, of the data and of draws, (draws + 1, residuals)."""
    rows = model.data.held_out
    return resampled_means(model.data.windows[rows], np.array([r[rows] ** 2 for r in residuals]))


def subsets_of(count: int) -> list[tuple[int, ...]]:
    """Of so many effects: those that shares are taken from."""
    whole = tuple(range(count))
    if 2**count <= MOST_SUBSETS:
        return [subset for size in range(count + 1) for subset in combinations(whole, size)]
    arcs = [tuple(sorted((k + j) % count for j in range(size))) for size in range(1, count) for k in whole]
    return [(), *arcs, whole]


def shapley(squares: Array, at: Mapping[tuple[int, ...], int], effect: int, count: int) -> Array:
    """What an effect takes off the mean square, in the mean over orders of adding, (draws + 1,).

    Args:
        squares: mean squares that subsets of the effects leave, (draws + 1, subsets).
        at: column of every subset.
        effect, count: its number among so many.
    """
    total, weights = np.zeros(len(squares)), 0.0
    pairs = [(s, tuple(sorted((*s, effect)))) for s in at if effect not in s]
    pairs = [(subset, joined) for subset, joined in pairs if joined in at]
    alike = Counter(len(subset) for subset, _ in pairs)
    for subset, joined in pairs:
        weight = factorial(len(subset)) * factorial(count - len(subset) - 1) / factorial(count)
        if len(at) < 2**count:
            weight = 1 / (count * alike[len(subset)])
        total += weight * (squares[:, at[subset]] - squares[:, at[joined]])
        weights += weight
    return total / weights


def _share(values: Array) -> Share:
    low, high = np.quantile(values[1:], [TAIL, 1 - TAIL])
    return Share(float(values[0]), float(low), float(high))
