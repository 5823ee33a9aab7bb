"""One cause in the place of several that together do what it does, or of one that is like it.

A link that is longer moves its markers as a slip of each would, one that bends turns its IMU as well. A search that
adds one cause at a time meets the parts first, and beside them the whole has nothing left to close. What it meets first
may also be what does most of several causes alone: beside the others it is another.
"""

from itertools import combinations

import numpy as np

from boom_mj.diagnosis.candidate import Candidate, apart
from boom_mj.diagnosis.scoring import Scored
from boom_mj.diagnosis.screening import Screening
from boom_mj.effects import Effect

PARTS = 2, 3  # causes that one may stand for: two markers and an IMU are what a link has


def wholes_of(found: Scored, screening: Screening, before: float) -> list[Candidate]:
    """Explanations with one other cause in the place of several, those that promise to suffice, best first.

    What parts change, d, is known by their derivatives; of it a cause makes the share s, by its column about the
    machine as built, while nuisances and the effects that stay follow. A gap g becomes (g^2 + (1 - s) <d, d>)^(1/2).

    Args:
        before: the gap as built in training.
    """
    model, effects, jacobian = found.model, found.fit.effects, found.fit.jacobian
    owners = np.array([owner for owner, *_ in found.fit.candidate.parameters])
    there, most = {*found.fit.candidate.places}, max(model.criteria.near_noise_gap, model.criteria.enough(before))
    promised: dict[Candidate, float] = {}
    for size in PARTS:
        for parts in combinations(range(len(effects)), size):
            mine = np.isin(owners, parts)
            stay = tuple(effect for k, effect in enumerate(effects) if k not in parts)
            change = jacobian[:, mine] @ found.fit.scaled[mine]
            alike, square = screening.imitations(stay, change, model, jacobian[:, ~mine])
            for one in alike:
                left = float(np.sqrt(found.train**2 + (1 - one.share) * square))
                if left <= most and not {*one.candidate.places} & there:
                    promised[Candidate((*stay, *one.candidate.effects))] = left
    return sorted(promised, key=promised.__getitem__)[: model.budget.leaders]


def likes_of(found: Scored, screening: Screening) -> list[Candidate]:
    """Explanations with one cause in the place of another that it is known to be confused with.

    Of every such kind the one at the same place, or where it does most of what the other does; of its own the one at
    another place that does most, if that is more than half of what its own column does. Causes that cannot stand beside
    it go.
    """
    model, effects, fit = found.model, found.fit.effects, found.fit
    owners = np.array([owner for owner, *_ in fit.candidate.parameters])
    others = dict[Candidate, None]()
    for k, effect in enumerate(effects):
        mine = owners == k
        alike, _ = screening.imitations((), fit.jacobian[:, mine] @ fit.scaled[mine], model, fit.jacobian[:, ~mine])
        ranked, likes = sorted(alike, key=lambda one: -one.share), dict[str, Effect]()
        own = max((one.share for one in alike if one.candidate.effects[0].cause == effect.cause), default=1.0)
        for like, share in ((one.candidate.effects[0], one.share) for one in ranked):
            if _like(effect, like, share > model.criteria.main_share * own):
                likes.setdefault(like.id, like)
        for like in likes.values():
            beside = (one for j, one in enumerate(effects) if j != k and apart(type(like), like.site, (one,)))
            others[Candidate((*beside, like))] = None
    return list(others)


def _like(effect: Effect, other: Effect, much: bool) -> bool:
    here = other.site.key == effect.site.key
    if other.id == effect.id:
        return much and not here
    confused = other.id in effect.confused_with or effect.id in other.confused_with
    return confused and (here or other.site.keys != effect.site.keys)
