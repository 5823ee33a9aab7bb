"""How unsure sizes are because a machine may have a little of every other effect, which nobody names.

An effect of the library that is not named has the size s, in sizes worth finding, with the prior N(0, d^2), d the
criterion `unnamed`. With G what its screening points change about the explained machine, J what the sizes that are
named do, P what nuisances with their priors leave of a column, and r what the explanation leaves, of mean square m,

    cov s = (G^T Q G / m + 1 / d^2)^-1,     s = cov s G^T Q r / m,     Q = P - P J (J^T P J + 1 / prior^2)^-1 J^T P,

so that sizes move by A s, A = H^-1 J^T P G (`scoring.deviations` for H). They are as unsure as A cov s A^T says and, as
what is said is their best value without s, as far as A s is.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from boom_mj.diagnosis.candidate import Kind
from boom_mj.diagnosis.lines import spectral_lines
from boom_mj.diagnosis.scoring import Scored, information
from boom_mj.diagnosis.screening import Screening


def allowing_for_others(found: Scored, kinds: Sequence[Kind]) -> Scored:
    """An explanation with sizes as unsure as that, by what the other effects of a library change about it."""
    model, effects = found.model, found.fit.effects
    screening = Screening(model, kinds, spectral_lines(model, found.fit.residual), effects, near=True)
    raw, every = model.residual(*model.predict([effects])), slice(None)
    equations = screening.equations_beside(raw, model, found.fit.jacobian)
    if not len(equations.slopes):
        return found
    left, columns = max(found.train, 1.0) ** 2, len(equations.slopes)
    covariance = np.linalg.inv(equations.curvature(every, every) / left + np.eye(columns) / model.criteria.unnamed**2)
    clean, inverse = information(model, found.fit)
    moves = inverse @ (clean.T @ screening.columns)
    moved = moves @ covariance @ (equations.slopes / left)
    variance = np.einsum("pc,cd,pd->p", moves, covariance, moves)
    return replace(found, deviation=np.sqrt(found.deviation**2 + variance + moved**2))
