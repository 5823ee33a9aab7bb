"""What counts as a difference: noise, the model's own error, and nuisances that no one calls a cause.

Residuals are whitened by V = D + e e^T in every channel, D = noise^2 + spread^2. What refining the model still changes
is added by Richardson extrapolation; the spread is half of its size within half a second, and e, a share of it as it
is (`FidelityLadder.alike`), may be wrong all along a channel. Nuisances are linear columns b_i with prior deviations
s_i, the tolerances of the subject: zero offsets, initial states, what varies between healthy machines. They are
estimated on the training entries and removed everywhere, so that with B = [b_i s_i] whitened

    <x, y> = x^T y - x^T B (1 + B^T B)^-1 B^T y        (sums over training entries)

is the inner product in which hypotheses are screened and fitted. A nuisance never exceeds a few prior deviations: one
that would is held there and leaves B.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from scipy.linalg import cholesky, solve_triangular
from scipy.ndimage import maximum_filter1d
from scipy.optimize import lsq_linear

from boom_mj.effects import Effect
from boom_mj.estimation.latent_input import NONE, Courses, courses_of
from boom_mj.systems.predictor import Campaign
from boom_mj.systems.system import Hypothesis, Level, Nuisance

Array = np.ndarray
LIMIT = 2.5  # prior deviations: what goes further is no tolerance but a cause
LEFT = 0.5  # share of the extrapolated change that may be wrong
FAILED = 1e3  # deviations
REACH = 5  # blocks over which the spread is carried, for phase
MADE = ("basis", "taught", "curvature", "_error")  # of weights, columns, courses, blur and model error


@dataclass(frozen=True)
class Metric:
    """Whitening and nuisances of a campaign.

    Attributes:
        campaign: what is measured.
        effects: of the machine about which all this is taken.
        individual: nuisances that are simulated along, at sizes estimated before.
        level: of fidelity at which changes of that machine are simulated.
        base: prediction of its simulation at the middle level less what those nuisances do in it, linearly, (N,).
        mean_error: what a finer model would add to it, (N,).
        doubt: that of which a share may be wrong, (N,).
        weight: 1 / sqrt(v), 0 where nothing was measured, (N,).
        columns: what nuisances change per prior deviation, (N, m).
        nuisances: what they are.
        blur: length of stretches of which only the mean counts, s; None where every entry does.
        courses: what they explain does not count; None where nothing has any.
    """

    campaign: Campaign
    effects: Hypothesis
    individual: Hypothesis
    level: Level
    base: Array
    mean_error: Array
    doubt: Array
    weight: Array
    columns: Array
    nuisances: tuple[Nuisance, ...]
    blur: float | None = None
    courses: Courses | None = None

    @cached_property
    def basis(self) -> Array:
        """Whitened columns, (N, m)."""
        return np.array([self.white(column) for column in self.columns.T]).reshape(self.columns.T.shape).T

    @cached_property
    def taught(self) -> Array:
        """The basis on the training entries, (training, m)."""
        return self.basis[self.campaign.train]

    @cached_property
    def curvature(self) -> Array:
        """1 + B^T B over the training entries, (m, m)."""
        return np.eye(len(self.nuisances)) + self.taught.T @ self.taught

    @cached_property
    def _error(self) -> tuple[Array, Array]:
        """The scaled error that may be all along a channel, (N,), and how much of it counts as such, (channels,)."""
        error = self.campaign.subject.fidelity.alike * self.doubt * self.weight
        square = np.bincount(self.campaign.channel_of, error**2, len(self.campaign.channels))
        return error, (1 - 1 / np.sqrt(1 + square)) / np.maximum(square, 1e-12)

    def predict(self, hypotheses: Sequence[Hypothesis], training_only: bool = False) -> list[Array]:
        """Predictions of hypotheses, (N,) each: the base, and what a model of our level says that they change in it."""
        whole = [(*effects, *self.individual) for effects in (self.effects, *hypotheses)]
        own, *found = self.campaign.predict(whole, self.level, training_only)
        return [self.base + (other - own) for other in found]

    def white(self, vector: Array) -> Array:
        """Whitened, zero where nothing was measured; huge where the simulation failed."""
        scale = np.where(self.weight > 0, self.weight, 1.0)
        scaled = np.where(self.weight > 0, np.where(np.isfinite(vector), vector * scale, FAILED), 0.0)
        error, share = self._error
        along = np.bincount(self.campaign.channel_of, error * scaled, len(share))
        whole = scaled - (share * along)[self.campaign.channel_of] * error
        whole = whole if self.courses is None else self.courses.without(whole)
        return whole if self.blur is None else self.campaign.blurred(whole, self.blur)

    def whitened(self, rows: slice, columns: Array) -> Array:
        """Columns (n, k) of a recording's entries, whitened but for courses and blur."""
        (error, share), kind = self._error, columns.dtype
        scaled = columns * self.weight[rows, None].astype(kind)
        for number in np.unique(self.campaign.channel_of[rows]):
            part = self.campaign.stretch(number)
            own, off = slice(part.start - rows.start, part.stop - rows.start), error[part].astype(kind)
            scaled[own] -= np.outer(off, share[number].astype(kind) * (off @ scaled[own]))
        return scaled

    def estimate(self, white: Array) -> Array:
        """Nuisances that whitened training entries ask for, in units of their prior deviation, within +-LIMIT, (m,)."""
        if not self.nuisances:
            return np.zeros(0)
        slope = self.taught.T @ white[self.campaign.train]
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
        inner = self.curvature[np.ix_(free, free)]
        follow = np.linalg.solve(inner, self.taught[:, free].T @ columns[self.campaign.train])
        return columns - self.basis[:, free] @ follow

    def residual(self, prediction: Array) -> Array:
        """Whitened measured - (prediction + mean error), (N,)."""
        return self.white(self.campaign.measured - prediction - self.mean_error)


def make_metric(campaign: Campaign) -> Metric:
    """Simulate the healthy machine at several fidelities and with every tolerance."""
    nuisances, fidelity = campaign.subject.tolerances(), campaign.subject.fidelity
    campaign.ahead([()], *(check.level for check in fidelity.checks), fidelity.middle)
    level = fidelity.coarse
    coarse, *shifted = campaign.predict([(), *(t.hypothesis for t in nuisances)], level)
    columns = [(s - coarse) * t.deviation for s, t in zip(shifted, nuisances)]
    return _weigh(campaign, ((), (), nuisances), level, columns, np.zeros(len(columns)))


def coarsely(metric: Metric) -> Metric:
    """The metric with changes simulated by the coarse model."""
    level = metric.campaign.subject.fidelity.coarse
    return metric if metric.level == level else _elsewhere(metric, level=level)


def blurred(metric: Metric) -> Metric:
    """The metric of slow changes alone, simulated roughly: a fit has one minimum in it where vibration makes many."""
    subject = metric.campaign.subject
    return replace(metric, blur=subject.window, level=subject.fidelity.rough)


def beside(metric: Metric, effects: Hypothesis) -> Metric:
    """The metric without nuisances that effects leave nothing of, and with the courses that they have."""
    nuisances = tuple(t.beside(effects) for t in metric.nuisances)
    if nuisances != metric.nuisances:
        kept = [bool(t.hypothesis) for t in nuisances]
        metric = replace(metric, columns=metric.columns * kept, nuisances=nuisances)
    return with_courses(metric, effects)


def with_courses(metric: Metric, effects: Hypothesis, training_only: bool = False) -> Metric:
    """The metric that does not count what courses of effects explain; those that it knows already stay."""
    if any(effect.pulse(0.0) for effect in effects) == (metric.courses is not None):
        return metric
    plain = replace(metric, blur=None, courses=None)
    residual = plain.clean(plain.residual(*plain.predict([effects], training_only)))
    campaign = metric.campaign
    recordings = campaign.learning if training_only else range(len(campaign.recordings))
    found = courses_of(campaign, effects, plain.whitened, residual, recordings)
    return replace(metric, courses=found)


def allowed(metric: Metric, effects: Hypothesis) -> Metric:
    """The metric without courses that are stronger than effects allow: without a wind there are no gusts."""
    if metric.courses is None or metric.courses.strength <= max(effect.strongest for effect in effects):
        return metric
    return replace(metric, courses=NONE)


def anchored(metric: Metric, effects: Hypothesis, estimate: Array, training_only: bool = False) -> Metric:
    """The metric with the base of a machine that has effects and nuisances; weights, columns, model error stay."""
    metric = beside(metric, effects)
    individual = of_size(metric.nuisances, estimate)
    level = metric.campaign.subject.fidelity.middle
    (base,) = metric.campaign.predict([(*effects, *individual)], level, training_only)
    return _elsewhere(metric, effects=effects, individual=individual, base=base - metric.columns @ estimate)


def _elsewhere(metric: Metric, **changes: Any) -> Metric:
    """The metric with another base or level: what was made of weights and columns is made once."""
    found = replace(metric, **changes)
    vars(found).update({name: made for name, made in vars(metric).items() if name in MADE})
    return found


def around(metric: Metric, effects: Hypothesis, estimate: Array) -> Metric:
    """The metric of a machine that has effects and nuisances: a heavier boom swings slower, with its own model error.

    Changes are simulated as the base is: the cost of a coarse model has minima of its own where nuisances meet limits.
    """
    campaign, kept = metric.campaign, anchored(metric, effects, estimate)
    nuisances = tuple(t.beside(effects) for t in campaign.subject.tolerances())
    whole, moving = (*effects, *kept.individual), [t for t in nuisances if not t.still]
    campaign.ahead([whole], *(check.level for check in campaign.subject.fidelity.checks))
    coarse = [whole, *((*whole, *t.hypothesis) for t in moving)]
    base, *shifted = campaign.predict(coarse, campaign.subject.fidelity.coarse)
    found = iter([(prediction - base) * t.deviation for prediction, t in zip(shifted, moving)])
    columns = [column if t.still else next(found) for column, t in zip(kept.columns.T, nuisances)]
    about = (effects, kept.individual, nuisances)
    return with_courses(_weigh(campaign, about, campaign.subject.fidelity.middle, columns, estimate), effects)


def of_size(nuisances: Sequence[Nuisance], estimate: Array) -> Hypothesis:
    """Nuisances as effects, one per cause, of sizes in prior deviations, (m,)."""
    kinds: dict[tuple, Effect] = {}
    values: dict[tuple, dict[str, float]] = {}
    for share, tolerance in zip(estimate, nuisances):
        for whole in tolerance.hypothesis:
            sizes, kinds[whole.cause] = values.setdefault(whole.cause, {}), whole
            for name, value in whole.values.items():
                neutral = whole.parameters[name].neutral
                if value != neutral:
                    size = sizes.get(name, neutral) + share * tolerance.deviation * (value - neutral)
                    sizes[name] = float(np.clip(size, *whole.parameters[name].bounds))
    return tuple(type(whole)(whole.location, **values[cause]) for cause, whole in kinds.items())


def _weigh(
    campaign: Campaign,
    about: tuple[Hypothesis, Hypothesis, tuple[Nuisance, ...]],
    level: Level,
    columns: Sequence[Array],
    estimate: Array,
) -> Metric:
    """The metric about a machine (effects, individual, nuisances) from its columns, without NaN."""
    (effects, individual, nuisances), fidelity = about, campaign.subject.fidelity
    levels = fidelity.middle, *(check.level for check in fidelity.checks)
    base, *finer = (campaign.predict([(*effects, *individual)], at)[0] for at in levels)
    changes = np.nan_to_num([found - base for found in finer])
    missing = np.array([check.missing for check in fidelity.checks]) @ changes
    doubt = np.array([check.doubtful for check in fidelity.checks]) @ changes
    variance = campaign.noise**2 + (LEFT * _carried(campaign, np.abs(doubt))) ** 2
    weight = np.where(campaign.used, 1 / np.sqrt(np.where(campaign.used, variance, 1.0)), 0.0)
    clean = np.array([np.nan_to_num(column) for column in columns]).reshape(len(columns), len(weight)).T
    base = base - clean @ estimate
    return Metric(campaign, effects, individual, level, base, missing, doubt, weight, clean, nuisances)


def _carried(campaign: Campaign, size: Array) -> Array:
    """Each channel's largest value within REACH blocks."""
    out = np.empty_like(size)
    for number in range(len(campaign.channels)):
        part = campaign.stretch(number)
        out[part] = maximum_filter1d(np.nan_to_num(size[part]), 2 * REACH + 1, mode="nearest")
    return out
