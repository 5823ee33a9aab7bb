"""Scoring a fit on entries that it has not seen, and how sure of it one can be."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import erf

from boom_mj.diagnosis.candidate import Candidate
from boom_mj.diagnosis.fitting import Fit
from boom_mj.diagnosis.linearisation import Linearisation
from boom_mj.effects import Effect
from boom_mj.estimation.bootstrap import Closure, closure, gap
from boom_mj.estimation.intervals import LEVEL, Z95, robust_variance
from boom_mj.estimation.least_squares import OPTIONS
from boom_mj.systems.system import Doubts, System

Array = np.ndarray
SCAN = 1e-3 * 2.0 ** np.arange(6)  # to either side, in terms of a size


@dataclass(frozen=True, eq=False)
class Scored:
    """A fit and its gaps.

    Attributes:
        fit: with its residual known everywhere.
        model: about which it was fitted.
        train, held_out: gaps, root mean square of the whitened residual.
        deviation: standard deviations of the scaled parameters, (p,).
    """

    fit: Fit
    model: Linearisation
    train: float
    held_out: float
    deviation: Array

    @property
    def gaps(self) -> tuple[float, float]:
        return self.train, self.held_out

    def by_effect(self, scaled: Array) -> list[Array]:
        """What is said of every parameter, (p,), for every effect by itself."""
        owners = np.array([owner for owner, *_ in self.fit.candidate.parameters])
        return [scaled[owners == k] for k in range(len(self.fit.effects))]

    def level(self, effect: Effect) -> float:
        """Of the widest interval of one of an effect's sizes that leaves out where it does nothing."""
        sized = [name not in self.fit.effects[owner].shapes for owner, name, _ in self.fit.candidate.parameters]
        away = self.by_effect(np.abs(self.fit.scaled) * sized / self.deviation)[self.fit.effects.index(effect)]
        return float(erf(np.max(away, initial=0.0) / np.sqrt(2)))

    def shows(self, effect: Effect) -> bool:
        """Whether the 95 % interval of one of an effect's sizes leaves out where it does nothing."""
        return self.level(effect) > LEVEL

    def rivals(self, best: "Scored") -> bool:
        """Whether it fits training well enough beside another to be refined (`close`).

        Of what does not, few held-out windows tell nothing.
        """
        return self.train <= self.model.budget.close * best.train

    @property
    def plausible(self) -> bool:
        """Whether all sizes are physically likely."""
        effects = self.fit.effects
        return all(e.declared[name].plausible(value) for e in effects for name, value in e.values.items())

    @property
    def doubt(self) -> float:
        """What unlikely sizes cost, in logarithms of mean squares."""
        return 0.0 if self.plausible else -2 * float(np.log(self.model.criteria.unlikely_gap))

    @property
    def refined(self) -> bool:
        """Whether it was fitted about the machine that its causes make."""
        return Candidate(self.model.effects).places == self.fit.candidate.places

    @property
    def label(self) -> str:
        return self.fit.candidate.label


def score(model: Linearisation, found: Fit) -> Scored:
    """Predict what was held out with what training gave."""
    data, model = model.data, model.allowing(found.effects)
    (prediction,) = model.predict([found.effects])
    whole = replace(found, residual=model.clean(model.residual(prediction)))
    gaps = gap(whole.residual, data.train), gap(whole.residual, data.held_out)
    return Scored(whole, model, *gaps, deviations(model, whole))


def deviations(model: Linearisation, found: Fit) -> Array:
    """Standard deviations of the parameters: H^-1 (sum g g^T) H^-1 with scores g summed over what is correlated.

    H = J^T P J + 1 / prior^2, with P what nuisances with their priors leave of a column, and g = J^T P r.
    Residuals are correlated within windows and, where the model is wrong, within whole recordings, and at the same
    moment of every pass of a motion that repeats. The largest counts, and no less than H^-1, what is left when
    nuisances may be anything that their priors allow, those at a limit too: it is a valley that ends there, not a wall.
    To what residuals show comes, where `gain_z` decides, what they cannot: an error of the model that looks like the
    parameter's own column and moved it instead of staying (`_hidden`). To both comes how far fits end apart where the
    cost is rough, and how unsure what the parameter changes is.
    """
    data, train = model.data, model.data.train
    clean, inverse = information(model, found)
    clusters = correlated(model, train)
    variance = robust_variance(inverse, clean * found.residual[train][:, None], clusters)
    if model.criteria.gain_z:
        alone = clusters[0] if model.facts.repeat_s is None else clusters[-1]
        variance = variance + _hidden(inverse, clean, found.residual[train], data.channel_of[train], alone)
    return np.sqrt(variance + found.rough**2 + _doubts(model.system, found) ** 2)


def _doubts(system: System, found: Fit) -> Array:
    """Of every parameter, scaled, (p,)."""
    if not isinstance(system, Doubts):
        return np.zeros(len(found.scaled))
    return np.array([system.doubt(found.effects[owner], name) for owner, name, _ in found.candidate.parameters])


def information(model: Linearisation, found: Fit) -> tuple[Array, Array]:
    """Sensitivities of training entries as they are felt while nuisances follow, (n, p), and H^-1, (p, p)."""
    train = model.data.train
    clean = model.posterior.project(found.jacobian, np.ones(len(model.nuisances), bool))[train]
    information = found.jacobian[train].T @ clean
    return clean, np.linalg.inv((information + information.T) / 2 + np.eye(clean.shape[1]) / OPTIONS.prior**2)


def correlated(model: Linearisation, rows: Array) -> list[Array]:
    """Clusters within which residuals of entries (N,) of bool are correlated: alternatives, (rows,) of int each.

    Windows, recordings, and the same moment of every pass of a motion that repeats.
    """
    data, repeat_s = model.data, model.facts.repeat_s
    repeated = [] if repeat_s is None else [data.moments(repeat_s)]
    return [cluster[rows] for cluster in (data.windows, data.recording_of, *repeated)]


def _hidden(inverse: Array, columns: Array, residual: Array, channel: Array, cluster: Array) -> Array:
    """Variance from model error that fits absorb, (p,): H^-1 (J^T D J) H^-1, D = n (m^2 - 1).

    Error as large as what is left of a channel, m^2 - 1 beyond noise, may have the column's own shape within every
    cluster, whose n entries then move the parameter together, and independently from one cluster to the next.
    """
    number = np.unique(channel * (cluster.max() + 1) + cluster, return_inverse=True)[1]
    groups = np.unique(channel, return_inverse=True)[1]
    excess = np.maximum(np.bincount(groups, residual**2) / np.bincount(groups) - 1, 0.0)[groups]
    weight = excess * np.bincount(number)[number]
    return np.diag(inverse @ (columns.T @ (columns * weight[:, None])) @ inverse)


def profiled(found: Scored, before: float) -> Scored:
    """With wider deviations where a cost has many minima: derivatives inform of one, model error decides.

    A size that leaves no more than the best and the share of the gap that jolts may (`rough_share`) is as
    good. From there a step by the derivatives leads to where all sizes might have ended as well.
    """
    model, candidate, at = found.model, found.fit.candidate, found.fit.scaled
    train, deviation = model.data.train, found.deviation.copy()
    (clean, inverse), enough, ends = information(model, found.fit), _as_good(found, before), list[Array]()
    for k, (owner, *_) in enumerate(candidate.parameters):
        if candidate.effects[owner].grid_start:
            points = at + np.outer(at[k] * np.r_[SCAN, -SCAN], np.eye(len(at))[k])
            seen = model.predict([candidate.at(point) for point in points], training_only=True)
            for point, white in zip(points, map(model.residual, seen)):
                if gap(model.clean(white), train) < enough:
                    deviation[k] = max(deviation[k], abs(point[k] - at[k]) / Z95)
                    ends.append(point - at + inverse @ (clean.T @ white[train] - point / OPTIONS.prior**2))
    if ends:
        deviation = np.hypot(deviation, np.sqrt(np.mean(np.square(ends), axis=0)))
    return replace(found, deviation=deviation)


def alternatives(ends: Sequence[Scored], before: float) -> Scored:
    """Of several ends of a fit the one that leaves least in training, as unsure as those that are as good are apart."""
    best = min(ends, key=lambda one: one.train)
    apart = [np.abs(one.fit.scaled - best.fit.scaled) / Z95 for one in ends if one.train < _as_good(best, before)]
    return replace(best, deviation=np.max([best.deviation, *apart], axis=0))


def _as_good(best: Scored, before: float) -> float:
    """What a size leaves in training that is as good as the best: more by the share that jolts may."""
    return best.train + best.model.criteria.rough_share * (before - 1)


def held_out_closure(model: Linearisation, before: Array, after: Array) -> Closure:
    """How much of a held-out gap went away between two whitened residuals, (N,)."""
    rows = model.data.held_out
    return closure(model.data.windows[rows], before[rows], after[rows])


def simplest_gap(model: Linearisation, best: Scored | None) -> float | None:
    """Held-out gap of the simplest model, without causes and with the best explanation, whichever is less."""
    level = model.facts.fidelity.simplest
    if level is None:
        return None
    hypotheses = [(), *([best.fit.effects] if best else [])]
    said = model.predictor.predict(hypotheses, level)
    left = [model.clean(model.noise.white(model.data.measured - one)) for one in said]
    return min(gap(one, model.data.held_out) for one in left)
