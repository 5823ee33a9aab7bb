"""Which terms, at which place: laws of few terms, first by what their columns explain, then fitted and simulated.

Every term is a law of its own that is screened as a candidate of the diagnosis is; sums of terms follow from the same
normal equations, so that a law of three terms costs no further simulation until it is fitted.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from boom_mj.diagnosis.candidate import Candidate
from boom_mj.diagnosis.clock import Clock
from boom_mj.diagnosis.criteria import SearchBudget
from boom_mj.diagnosis.fitting import fit
from boom_mj.diagnosis.linearisation import Linearisation
from boom_mj.diagnosis.scoring import Scored, score
from boom_mj.diagnosis.screening import Screening
from boom_mj.discovery.grammar import Term
from boom_mj.discovery.places import Place, first_order, law_class
from boom_mj.estimation.intervals import Z95
from boom_mj.estimation.least_squares import OPTIONS

Array = np.ndarray
ROUNDING = 1e-6  # of a column's square: products of columns in single precision are no better


@dataclass(frozen=True, eq=False)
class Column:
    """A term with one shape, as it was screened."""

    place: Place
    term: Term
    shape: float | None
    part: slice


@dataclass(frozen=True, eq=False)
class Sum:
    """Terms at a place, with the values that screening suggests and the share of the training misfit they explain."""

    place: Place
    terms: tuple[Term, ...]
    values: dict[str, float]
    share: float


@dataclass(frozen=True, eq=False)
class FoundLaw:
    """A law, fitted: its place, its terms, how it does."""

    place: Place
    terms: tuple[Term, ...]
    scored: Scored

    @property
    def held_out(self) -> float:
        """Gap that it leaves."""
        return self.scored.held_out

    @property
    def residual(self) -> Array:
        """What it leaves, whitened, (N,)."""
        return self.scored.fit.residual

    @property
    def certain(self) -> bool:
        """Whether every term has a coefficient whose 95 % interval does not hold 0."""
        sizes = {
            name: abs(size) > Z95 * deviation
            for (_, name, _), size, deviation in zip(
                self.scored.fit.candidate.parameters, self.scored.fit.scaled, self.scored.deviation
            )
        }
        return all(any(sizes[part.coefficient] for part in term.parts) for term in self.terms)

    @property
    def size(self) -> int:
        """Numbers that it takes."""
        return len(self.scored.fit.scaled)


def possible(model: Linearisation, as_built: Array, places: Sequence[Place]) -> list[Place]:
    """Places whose law could close most of the gap: a sensor's law can close no more than lies in its channel."""
    data = model.data
    excess = np.where(data.train & data.used, as_built**2 - 1, 0.0)
    own = np.bincount(data.channel_of, excess, len(data.channels))
    whole = max(float(own.sum()), 1e-12)

    def share(place: Place) -> float:
        mine = [k for k, c in enumerate(data.channels) if (c.signal, c.column) == place.channel]
        return float(own[mine].sum()) / whole if place.channel else 1.0

    return [place for place in places if share(place) > model.criteria.main_share]


def sums(model: Linearisation, raw: Array, places: Sequence[Place]) -> list[list[Sum]]:
    """The best sums of terms at every place, best place first, by size of the sum and then by share.

    All terms of a place count only where its first ones explain their share (`main_share`) of what the best place does.
    """
    found = _screened(model, raw, {place: place.terms[: place.first] for place in places})
    least = model.criteria.main_share * max(map(_promise, found.values()), default=0.0)
    more = {place: place.terms for place, own in found.items() if place.first and _promise(own) >= least}
    return sorted((found | (_screened(model, raw, more) if more else {})).values(), key=_promise, reverse=True)


def _promise(own: Sequence[Sum]) -> float:
    return max(one.share for one in own)


def _screened(model: Linearisation, raw: Array, places: Mapping[Place, Sequence[Term]]) -> dict[Place, list[Sum]]:
    """The best sums of some terms at every place."""
    kinds = {first_order(place, term): (place, term) for place, terms in places.items() for term in terms}
    screening = Screening(model, [(kind, place.site) for kind, (place, _) in kinds.items()], ())
    columns = dict[Place, list[Column]]()
    for (kind, _, group), part in zip(screening.rows, screening.stretches):
        place, term = kinds[kind]
        shape = group[0].get(term.shape.name) if term.shape else None
        columns.setdefault(place, []).append(Column(place, term, shape, part))
    slopes, curvature, _, whole = screening.normal_equations(raw)
    found = {}
    for place, own in columns.items():
        numbers = np.concatenate([np.arange(c.part.start, c.part.stop) for c in own])
        size = np.einsum("nc,nc->c", screening.columns[:, numbers], screening.columns[:, numbers])
        square = curvature(numbers, numbers) + np.diag(ROUNDING * size)
        found[place] = _beam(place, own, numbers, slopes[numbers], square, whole, model.budget)
    return found


def _beam(
    place: Place,
    own: Sequence[Column],
    numbers: Array,
    slopes: Array,
    square: Array,
    whole: float,
    budget: SearchBudget,
) -> list[Sum]:
    """Beam search over sums of columns; of two columns all, since what is mostly cancelled is no good alone."""
    where = {column: np.searchsorted(numbers, np.arange(column.part.start, column.part.stop)) for column in own}
    square = square + np.eye(len(square)) / OPTIONS.prior**2

    def explained(chosen: Sequence[Column]) -> tuple[float, Array]:
        rows = np.concatenate([where[column] for column in chosen])
        weights = np.linalg.solve(square[np.ix_(rows, rows)], slopes[rows])
        return float(slopes[rows] @ weights) / whole, weights

    found: list[Sum] = []
    beam: list[tuple[Column, ...]] = [()]
    for size in range(1, budget.law_terms + 1):
        longer = {frozenset((*chosen, c)): (*chosen, c) for chosen in beam for c in own if _apart(c, chosen)}
        ranked = sorted(longer.values(), key=lambda chosen: -explained(chosen)[0])
        forms = dict[frozenset[str], tuple[Column, ...]]()
        for chosen in ranked:  # one shape of a form is enough: fits find the others
            forms.setdefault(frozenset(column.term.name for column in chosen), chosen)
        best = list(forms.values())[: budget.law_beam]
        found += [_sum(place, chosen, *explained(chosen)) for chosen in best]
        beam = ranked if size == 1 else best
    return found


def _apart(column: Column, chosen: Sequence[Column]) -> bool:
    """Whether a term may stand beside others: it and each of its parameters once."""
    return not _names(column.term) & {name for c in chosen for name in _names(c.term)}


def _names(term: Term) -> set[str]:
    return {term.name, *(part.coefficient for part in term.parts), *((term.shape.name,) if term.shape else ())}


def _sum(place: Place, chosen: Sequence[Column], share: float, weights: Array) -> Sum:
    values, left = dict[str, float](), iter(weights)
    for column in chosen:
        shape = {column.term.shape.name: column.shape} if column.term.shape else {}
        for part in column.term.parts:
            values[part.coefficient] = float(next(left)) * _typical(place, column.term, part.coefficient)
        values |= {name: float(value) for name, value in shape.items() if value is not None}
    return Sum(place, tuple(column.term for column in chosen), values, share)


def _typical(place: Place, term: Term, coefficient: str) -> float:
    return law_class(place, (term,)).table[coefficient].typical


def fitted(model: Linearisation, ranked: Sequence[Sequence[Sum]], before: float, clock: Clock) -> Iterator[FoundLaw]:
    """The best sums at the best places, fitted in the loop and scored.

    Longer ones only where shorter ones leave a gap of which they promise to close their share (`required_gain`), or of
    two terms at the best place, since promises are linear.

    Args:
        before: gap in training.
    """
    budget, share = model.budget, model.criteria.main_share
    least = share * max(map(_promise, ranked), default=0.0)
    likely = [one for one in ranked if _promise(one) >= least][: budget.law_places]
    for at_place in likely:
        shorter = np.inf  # mean square above noise that sums promise to leave
        for size in range(1, budget.law_terms + 1):
            own = [s for s in at_place if len(s.terms) == size]
            left = min(((1 - s.share) * before**2 - 1 for s in own), default=np.inf)
            promising = left <= (1 - model.criteria.required_gain) * shorter
            if not promising and not (size == 2 and at_place is likely[0]):
                continue
            found, shorter = [], left
            for one in own[: budget.law_forms]:
                if clock.over(f"{' + '.join(t.name for t in one.terms)} on {one.place.acts_on}"):
                    return
                found.append(fit_law(model, one, clock))
                yield found[-1]
            if any(max(law.scored.gaps) <= model.criteria.explained_gap for law in found):
                break


def fit_law(model: Linearisation, one: Sum, clock: Clock) -> FoundLaw:
    """A sum of terms fitted from where screening saw it."""
    kind = law_class(one.place, one.terms, one.values)
    inside = {name: float(np.clip(v, *kind.parameters(one.place.site)[name].bounds)) for name, v in one.values.items()}
    scored = score(model, fit(model, Candidate((kind(one.place.site, **inside),)), clock=clock))
    return FoundLaw(one.place, one.terms, scored)
