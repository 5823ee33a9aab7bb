"""Whether a cause only stands in for another law at its place.

Where a law is not in the library, the most similar one closes part of the gap, and nothing else in the library does as
well: it would be sure, and wrong. So what resists its joint is set free to be any function of speed; if that closes
most of what the cause leaves, the place is right and the law is not.
"""

from collections.abc import Iterator

from boom_mj.diagnosis.candidate import Candidate
from boom_mj.diagnosis.clock import Clock
from boom_mj.diagnosis.fitting import fit
from boom_mj.diagnosis.scoring import Scored, score
from boom_mj.effects.free_resistance import FreeResistance


def freed(best: Scored, clock: Clock) -> Iterator[Scored]:
    """The explanation with a free resistance for an effect of a joint, where that closes its share of what is left."""
    effects, criteria = best.fit.effects, best.model.criteria
    for one in effects:
        at_a_joint = one.site.keys == FreeResistance.at and FreeResistance.needs <= one.site.tags
        if at_a_joint and not clock.over(f"another law than {one.id} at its place"):
            others = (other for other in effects if other is not one)
            candidate = Candidate((*others, FreeResistance(one.site)))
            found = score(best.model, fit(best.model, candidate, clock=clock))
            if best.held_out - found.held_out > criteria.main_share * (best.held_out - 1):
                yield found
