"""What recordings cannot tell of a library: effects that look like others, and effects that do not show at all.

A kind of effect counts by the share of its sites.
"""

from collections.abc import Callable, Iterable

import numpy as np

from boom_mj.diagnosis.candidate import apart
from boom_mj.diagnosis.screening import Screening
from boom_mj.systems.system import Hypothesis

Array = np.ndarray


def mimicked(screening: Screening, effects: Hypothesis, residual: Array, left: float) -> float:
    """How many kinds of other effects these would explain, had one of them caused a gap as large as a residual's.

    With u the part of a column that is none of the effects' columns, they would leave the mean square 1 + u e, e what
    is above the floor: little enough, and the rest enough to count.

    Args:
        residual: whitened, (N,).
        left: gap that the effects leave in training.
    """
    equations, criteria = screening.normal_equations(residual), screening.model.criteria
    excess = equations.whole / len(screening.columns) - min(left, 1.0) ** 2
    own = screening.parts_of(effects)
    if not own:
        return 0.0
    mine = np.concatenate([np.arange(part.start, part.stop) for part in own])
    across = equations.curvature(mine, np.arange(screening.columns.shape[1]))
    explained = np.einsum("kc,kc->c", across, np.linalg.pinv(across[:, mine], hermitian=True) @ across)
    other = 1 - explained / np.maximum(equations.diagonal, 1e-12)
    takes = (1 + other * excess <= criteria.explained_gap**2) & ((1 - other) * excess > criteria.least_gain)
    rows = [(kind, site, takes[part]) for (kind, site, _), part in zip(screening.rows, screening.stretches)]
    return sum(_kinds(((kind.id, site.key, like) for kind, site, like in rows if apart(kind, site, effects)), all))


def unseen(screening: Screening, residual: Array) -> float:
    """The share of kinds of effects that do not count in training, of the largest size screened.

    Args:
        residual: whitened, (N,).
    """
    square = screening.normal_equations(residual).diagonal / len(screening.columns)
    seen = square > screening.model.criteria.least_gain
    rows = ((kind.id, site.key, seen[part]) for (kind, site, _), part in zip(screening.rows, screening.stretches))
    return 1 - float(np.mean(_kinds(rows, any)))


def _kinds(rows: Iterable[tuple[str, tuple, Array]], whole: Callable[[Iterable[bool]], bool]) -> list[float]:
    """Of every kind the share of its sites at which all of its points, or any, are what rows say."""
    found: dict[str, dict[tuple, list[bool]]] = {}
    for kind, site, points in rows:
        found.setdefault(kind, {}).setdefault(site, []).extend(map(bool, points))
    return [float(np.mean([whole(points) for points in places.values()])) for places in found.values()]
