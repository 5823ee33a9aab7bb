"""What counts as a difference: noise, the model's own error, and nuisances that no one calls a cause.

Residuals are whitened by v = noise^2 + spread^2. The spread is what refining the model still changes; the mean
of that change is taken out by Richardson extrapolation. Nuisances are linear columns b_i with prior deviations s_i, the
tolerances of the subject: zero offsets, initial states, what varies between healthy machines. They are estimated on the
training entries and removed everywhere, so that with B = [b_i s_i] whitened

    <x, y> = x^T y - x^T B (1 + B^T B)^-1 B^T y        (sums over training entries)

is the inner product in which hypotheses are screened and fitted. A nuisance never exceeds a few prior deviations: one
that would is held there and leaves B.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import cholesky, solve_triangular
from scipy.ndimage import maximum_filter1d
from scipy.optimize import lsq_linear

from boom_mj.gap.campaign import Campaign
from boom_mj.gap.subject import Hypothesis, Tolerance

Array = np.ndarray
LIMIT = 2.5  # prior deviations: what goes further is no tolerance but a cause
LEFT = 0.5  # share of the extrapolated change that may be wrong
REACH = 5  # blocks over which the spread is carried, for phase


@dataclass(frozen=True)
class Metric:
    """Whitening and nuisances of a campaign.

    Attributes:
        campaign: what is measured.
        effects: of the machine about which all this is taken.
        level: of fidelity at which changes of that machine are simulated.
        base: prediction of its simulation at the middle level, (N,).
        mean_error: what a finer model would add to it, (N,).
        weight: 1 / sqrt(v), 0 where nothing was measured, (N,).
        basis: whitened nuisance columns times their prior deviations, (N, m).
        nuisances: what they are.
        curvature: 1 + B^T B over the training entries, (m, m).
    """

    campaign: Campaign
    effects: Hypothesis
    level: int
    base: Array
    mean_error: Array
    weight: Array
    basis: Array
    nuisances: tuple[Tolerance, ...]
    curvature: Array

    def predict(self, hypotheses: Sequence[Hypothesis], training_only: bool = False) -> list[Array]:
        """Predictions of hypotheses, (N,) each: the base, and what a model of our level says that they change in it."""
        own, *found = self.campaign.predict([self.effects, *hypotheses], self.level, training_only)
        return [self.base + (other - own) for other in found]

    def white(self, vector: Array) -> Array:
        """Whitened, zero where nothing was measured; infinite where the simulation failed."""
        seen = self.weight > 0
        return np.where(
            seen, np.where(np.isfinite(vector), vector, 1e3 / np.where(seen, self.weight, 1)) * self.weight, 0.0
        )

    def estimate(self, white: Array) -> Array:
        """Nuisances that whitened training entries ask for, in units of their prior deviation, within +-LIMIT, (m,)."""
        if not self.nuisances:
            return np.zeros(0)
        slope = self.basis[self.campaign.train].T @ white[self.campaign.train]
        root = cholesky(self.curvature)  # upper: |root x - root^-T slope|^2 is what x minimises
        return lsq_linear(root, solve_triangular(root, slope, trans="T"), (-LIMIT, LIMIT)).x

    def free(self, estimate: Array) -> Array:
        """Nuisances that are not at their limit, (m,) of bool."""
        return np.abs(estimate) < LIMIT * (1 - 1e-6)

    def clean(self, white: Array) -> Array:
        """A whitened residual (N,) without what nuisances explain of its training entries."""
        return white - self.basis @ self.estimate(white)

    def project(self, columns: Array, free: Array) -> Array:
        """Whitened columns (N, k) as they are felt while the free nuisances follow."""
        train, basis = self.campaign.train, self.basis[:, free]
        inner = self.curvature[np.ix_(free, free)]
        return columns - basis @ np.linalg.solve(inner, basis[train].T @ columns[train])

    def residual(self, prediction: Array) -> Array:
        """Whitened measured - (prediction + mean error), (N,)."""
        return self.white(self.campaign.measured - prediction - self.mean_error)


def make_metric(campaign: Campaign) -> Metric:
    """Simulate the healthy machine at several fidelities and with every tolerance."""
    nuisances, level = campaign.subject.tolerances(), campaign.subject.fidelity.coarse
    coarse, *shifted = campaign.predict([(), *(t.hypothesis for t in nuisances)], level)
    return _weigh(campaign, (), level, [(s - coarse) * t.deviation for s, t in zip(shifted, nuisances)])


def coarsely(metric: Metric) -> Metric:
    """The metric with changes simulated by the coarse model."""
    return replace(metric, level=metric.campaign.subject.fidelity.coarse)


def anchored(metric: Metric, effects: Hypothesis) -> Metric:
    """The metric with the base of a machine that has effects; weights and nuisances stay, changes are coarse."""
    (base,) = metric.campaign.predict([effects], metric.campaign.subject.fidelity.middle)
    return coarsely(replace(metric, effects=effects, base=base))


def around(metric: Metric, effects: Hypothesis) -> Metric:
    """The metric of a machine that has effects: a heavier boom swings slower, with its nuisances and model error.

    Changes are simulated as the base is: the cost of a coarse model has minima of its own where nuisances meet limits.
    """
    campaign, moving = metric.campaign, [t for t in metric.nuisances if not t.still]
    hypotheses = [effects, *((*effects, *t.hypothesis) for t in moving)]
    base, *shifted = campaign.predict(hypotheses, campaign.subject.fidelity.coarse)
    found = iter([(prediction - base) * t.deviation for prediction, t in zip(shifted, moving)])
    kept = metric.basis / np.where(metric.weight > 0, metric.weight, 1)[:, None]
    level = campaign.subject.fidelity.middle
    return _weigh(campaign, effects, level, [c if t.still else next(found) for c, t in zip(kept.T, metric.nuisances)])


def _weigh(campaign: Campaign, effects: Hypothesis, level: int, columns: Sequence[Array]) -> Metric:
    fidelity = campaign.subject.fidelity
    fine, base = (campaign.predict([effects], level)[0] for level in (fidelity.fine, fidelity.middle))
    refinement = (fine - base) / fidelity.shrunk
    variance = campaign.noise**2 + (LEFT * _carried(campaign, np.abs(refinement))) ** 2
    weight = np.where(campaign.used, 1 / np.sqrt(np.where(campaign.used, variance, 1.0)), 0.0)
    basis = np.zeros((len(weight), 0))
    if columns:
        basis = np.stack([np.nan_to_num(column) * weight for column in columns], axis=1)
    train = campaign.train
    curvature = np.eye(len(columns)) + basis[train].T @ basis[train]
    return Metric(campaign, effects, level, base, refinement, weight, basis, campaign.subject.tolerances(), curvature)


def _carried(campaign: Campaign, size: Array) -> Array:
    """Each channel's largest value within REACH blocks."""
    out = np.empty_like(size)
    for number in range(len(campaign.channels)):
        part = campaign.stretch(number)
        out[part] = maximum_filter1d(np.nan_to_num(size[part]), 2 * REACH + 1, mode="nearest")
    return out
