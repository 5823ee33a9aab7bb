"""The diagnosis: fidelity and nuisances, screening, single causes, combinations, and scores on held-out data."""

from collections.abc import Callable, Sequence

from threadpoolctl import threadpool_limits

from boom_mj.diagnosis.candidate import everywhere
from boom_mj.diagnosis.clock import Clock
from boom_mj.diagnosis.conclusion import Diagnosis, concluded
from boom_mj.diagnosis.decision import sure, useful
from boom_mj.diagnosis.linearisation import linearise
from boom_mj.diagnosis.lines import spectral_lines
from boom_mj.diagnosis.mimicry import mimicked, unseen
from boom_mj.diagnosis.outlying import MOST, Outlier, outlying
from boom_mj.diagnosis.scoring import Scored
from boom_mj.diagnosis.screening import Screened, Screening
from boom_mj.diagnosis.stages import combined, refined, singles
from boom_mj.diagnosis.unnamed import allowing_for_others
from boom_mj.estimation.bootstrap import gap
from boom_mj.systems.predictor import Predictor

Keep = Callable[[Diagnosis], None]


def diagnose(
    predictor: Predictor,
    without: Sequence[str] = (),
    clock: Clock | None = None,
    most: int | None = None,
    keep: Keep = lambda found: None,
) -> Diagnosis:
    """Find what a machine has that its nominal model lacks.

    Where that leaves a gap that is mostly one sensor's or a few seconds', the rest is diagnosed without (`outlying`).

    Args:
        predictor: of its system and recordings.
        without: ids of effects that are withheld from the library.
        clock: how much time there is, and who hears one line per stage.
        most: causes that an explanation may have; if left out those of the system's facts, and more that show beside an
            explanation that suffices.
        keep: is given what is known after every stage, the best so far.
    """
    with threadpool_limits(1):  # simulations have the cores
        clock = clock or Clock()
        return _allowing_for_others(_of_most(predictor, without, clock, most, keep), without, clock)


def _allowing_for_others(found: Diagnosis, without: Sequence[str], clock: Clock) -> Diagnosis:
    """With sizes as unsure as small effects that are not named make them (`unnamed`)."""
    if not (found.best and found.criteria.unnamed) or clock.over("small effects that are not named"):
        return found
    clock.tell("how small effects that are not named move sizes")
    kinds = everywhere(found.model.system, without)
    return found.after(lambda one: allowing_for_others(one, kinds))


def _of_most(
    predictor: Predictor,
    without: Sequence[str],
    clock: Clock,
    most: int | None,
    keep: Keep,
    outliers: tuple[Outlier, ...] = (),
    whole: Diagnosis | None = None,
) -> Diagnosis:
    """The diagnosis of all but outliers, or of the whole where the rest is not explained either."""
    found = _diagnose(predictor, without, clock, most, lambda so_far: keep(so_far.but_for(outliers, whole)))
    if found.verdict not in ("partial", "unexplained"):
        return found.but_for(outliers, whole)
    whole = whole or found
    part = outlying(found.model, found.as_built, found.scored) if len(outliers) < MOST else None
    if part is None or clock.over(f"the rest without {part.name}"):
        return whole
    clock.tell(f"{part.name} disagrees with all else; without that")
    rest = found.model.predictor.hiding(part.rows)
    return _of_most(rest, without, clock, most, keep, (*outliers, part), whole)


def _diagnose(predictor: Predictor, without: Sequence[str], clock: Clock, most: int | None, keep: Keep) -> Diagnosis:
    clock.tell("fidelity and nuisances")
    model = linearise(predictor)
    data, criteria = model.data, model.criteria
    raw = model.residual(model.base)
    as_built = model.clean(raw)
    gaps = training, before = gap(as_built, data.train), gap(as_built, data.held_out)
    clock.tell(f"gap as built {training:.2f} in training, {before:.2f} held out; screening")
    screened: list[Screened] = []
    screening = None
    if not clock.over("the library"):
        screening = Screening(model, everywhere(model.system, without), spectral_lines(model, as_built))
        clock.tell(f"{len(screening.rows)} candidates screened")
        screened = screening.rank(raw)

    def conclude(scored: Sequence[Scored]) -> Diagnosis:
        alike = [mimicked(screening, j.fit.effects, raw, j.train) for j in scored] if screening else None
        hidden = unseen(screening, raw) if screening else 1.0
        return concluded(model, as_built, screened, scored, alike, hidden, clock)

    scored: list[Scored] = []
    promise = screened[0].share * training**2 if screened else 0.0
    if screened and (max(gaps) > criteria.healthy_gap or promise > criteria.least_gain):
        scored = singles(model, screened, gaps, clock)
    worth = any(before > criteria.healthy_gap or (useful(j, gaps) and sure(as_built, j)) for j in scored)
    if worth:
        keep(conclude(scored))
        scored = refined(scored, gaps, clock)
    found = conclude(scored)
    keep(found)
    other = _extended(found, without, clock, most, keep)
    if worth and screening and not other:
        found = conclude(combined(scored, gaps, screening, clock, most))
        other = _extended(found, without, clock, most, keep)
    return other if other and other.solved else found


def _extended(found: Diagnosis, without: Sequence[str], clock: Clock, most: int | None, keep: Keep) -> Diagnosis | None:
    """The diagnosis where part of a recording held out trains what no other recording shows; its rest is held out.

    Only where what is left of training suffices: a search that ends short of that would end so again.
    """
    data = found.model.data
    hidden = {k: size for k, size in found.not_trained.items() if k not in data.extended}
    left, enough = gap(found.trained, data.train), found.criteria.enough(gap(found.as_built, data.train))
    if not hidden or left > enough:
        return None
    largest = max(hidden, key=hidden.__getitem__)
    part = f"{found.model.facts.wording.first_part} of {data.recordings[largest].name}"
    if clock.over(f"training with {part}"):
        return None
    clock.tell(f"training recordings do not show the gap; training with {part} as well")
    return _diagnose(found.model.predictor.extending(largest), without, clock, most, keep)
