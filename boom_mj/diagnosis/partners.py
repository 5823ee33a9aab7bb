"""Partners of a leader: what screening about the machine that it makes suggests beside it."""

from collections.abc import Mapping, Sequence

import numpy as np

from boom_mj.diagnosis.candidate import Candidate, Kind, apart
from boom_mj.diagnosis.clock import Clock
from boom_mj.diagnosis.linearisation import Linearisation
from boom_mj.diagnosis.lines import spectral_lines
from boom_mj.diagnosis.scoring import Scored
from boom_mj.diagnosis.screening import Screened, Screening
from boom_mj.effects import Effect
from boom_mj.estimation.bootstrap import gap

Array = np.ndarray


def shortlist(model: Linearisation, screened: Sequence[Screened]) -> list[Screened]:
    """The best few, and the best of each kind that explains a share worth a simulation."""
    budget = model.budget
    chosen = list(screened[: budget.finalists])
    kinds = {s.candidate.effects[0].id for s in chosen}
    for s in screened[budget.finalists :]:
        worth = s.share > budget.kind_share * screened[0].share
        if s.candidate.effects[0].id not in kinds and worth and len(chosen) < budget.finalists + budget.kinds_beyond:
            chosen.append(s)
            kinds.add(s.candidate.effects[0].id)
    return chosen


def partners_of(model: Linearisation, trunk: tuple[Effect, ...], screening: Screening, clock: Clock) -> list[Screened]:
    """What screening suggests about the machine that effects make.

    Simulated are those that at a glance promise most and a sample of the others; where these surprise, all. Where fits
    are short the best of other kinds are among them: a size far from the screened one promises too little.
    """
    clock.tell("screening beside " + Candidate(trunk).label)
    model, raw, lines = _about(model, trunk)
    few = model.facts.oscillatory
    count = model.budget.partners if few else model.budget.finalists
    glance = screening.beside(trunk, raw, lines)
    kinds, first = list(glance), count + list(glance.values()).count(np.inf)
    sample = kinds[:first] + kinds[first :: model.budget.every]
    some = Screening(model, sample, lines, trunk, near=True)
    ranked = some.rank(raw)
    others = [promise for kind, promise in glance.items() if kind not in sample]
    if others and (_surprising(ranked, glance, model.budget.surprise) or max(others) > ranked[:count][-1].share):
        ranked = Screening(model, kinds, lines, trunk, done=some).rank(raw)
    return ranked[:count] if few else shortlist(model, ranked)


def hidden_partners(
    model: Linearisation, trunk: tuple[Effect, ...], screening: Screening, clock: Clock
) -> list[Screened]:
    """All of the library that promises a share of the best about the machine that effects make.

    Where a size of one of them does a missing cause's part, that one promises little, and at a glance nothing: a softer
    link turns the phase of what swings back that too large a load has turned.
    """
    clock.tell("screening all beside " + Candidate(trunk).label)
    model, raw, lines = _about(model, trunk)
    ranked = Screening(model, screening.kinds, lines, trunk, near=True).rank(raw)
    return [one for one in ranked if one.share > model.budget.kind_share * ranked[0].share]


def _about(model: Linearisation, trunk: tuple[Effect, ...]) -> tuple[Linearisation, Array, list[float]]:
    """The machine that effects make, the whitened residual that it leaves (N,), and the frequencies in it."""
    model = model.conditional_on(trunk)
    raw = model.residual(*model.predict([trunk]))
    return model, raw, spectral_lines(model, model.clean(raw))


def _surprising(ranked: Sequence[Screened], glance: Mapping[Kind, float], surprise: float) -> bool:
    """Whether any promises more than at a glance, by a share of the best; a latent input is more than its column."""
    effects = [one.candidate.effects[0] for one in ranked]
    more = [s.share - glance[type(e), e.site] for s, e in zip(ranked, effects) if not e.basis(0.0)]
    return max(more, default=0.0) > surprise * ranked[0].share


def pairs_of(trunk: tuple[Effect, ...], partners: Sequence[Screened]) -> list[tuple[Candidate, float]]:
    """Effects together with partners, and what these promise."""
    return [(Candidate((*trunk, *start.effects)), partner.share) for partner in partners for start in partner.starts]


def shared(trunk: tuple[Effect, ...], scored: Sequence[Scored]) -> list[tuple[Candidate, float]]:
    """Effects together with the best of those that do not share a cause with them: each may stand for part of both."""
    alone = [j.fit.effects[0] for j in scored if len(j.fit.effects) == 1]
    free = [effect for effect in alone if apart(type(effect), effect.site, trunk)]
    return [(Candidate((*trunk, effect)), 0.0) for effect in free[: scored[0].model.budget.singles_beside]]


def without_the_least(found: Scored) -> tuple[Effect, ...]:
    """Effects but the one that does least beside the others; not the last, to which others were tried."""
    model, effects, train = found.model, found.fit.effects, found.model.data.train
    fewer = [(*effects[:k], *effects[k + 1 :]) for k in range(len(effects) - 1)]
    if len(fewer) == 1:
        return fewer[0]
    left = [gap(model.clean(model.residual(one)), train) for one in model.predict(fewer, training_only=True)]
    return fewer[int(np.argmin(left))]
