"""Judging a fit on entries that it has not seen, and how sure of it one can be.

The gap is the root mean square of the whitened residual: 1 is the floor of noise and model error. Samples are
correlated, so that every interval comes from windows of some seconds that are resampled or summed whole.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.stats import norm as normal

from boom_mj.diagnosis.fitting import PRIOR, Fit
from boom_mj.diagnosis.linearisation import Metric, allowed
from boom_mj.estimation.intervals import SURE, robust_variance

Array = np.ndarray
DRAWS = 400
LOOKS = 1e-3 * 2.0 ** np.arange(6)  # to either side, in terms of a size


@dataclass(frozen=True, eq=False)
class Scored:
    """A fit and its gaps.

    Attributes:
        fit: with its residual known everywhere.
        metric: in which it was fitted.
        train, held_out: gaps, root mean square of the whitened residual.
        deviation: standard deviations of the coordinates, (p,).
    """

    fit: Fit
    metric: Metric
    train: float
    held_out: float
    deviation: Array

    @property
    def gaps(self) -> tuple[float, float]:
        return self.train, self.held_out

    @property
    def label(self) -> str:
        return self.fit.candidate.label


def gap(residual: Array, rows: Array) -> float:
    """Root mean square over the given entries; NaN where there are none."""
    return float(np.sqrt(np.mean(residual[rows] ** 2))) if rows.any() else float("nan")


def judge(metric: Metric, found: Fit) -> Scored:
    """Predict what was held out with what was learnt in training."""
    campaign = metric.campaign
    metric = allowed(metric, found.effects)
    (prediction,) = metric.predict([found.effects])
    whole = replace(found, residual=metric.clean(metric.residual(prediction)))
    held_out = gap(whole.residual, campaign.held_out)
    return Scored(whole, metric, gap(whole.residual, campaign.train), held_out, deviations(metric, whole))


def deviations(metric: Metric, found: Fit) -> Array:
    """Standard deviations of the coordinates: H^-1 (sum g g^T) H^-1 with scores g summed over what is correlated.

    H = J^T P J + 1 / PRIOR^2, with P what nuisances with their priors leave of a column, and g = J^T P r.
    Residuals are correlated within windows and, where the model is wrong, within whole recordings, and at the same
    moment of every pass of a motion that repeats. The largest counts, and no less than H^-1, what is left when
    nuisances may be anything that their priors allow, those at a limit too: it is a valley that ends there, not a wall.
    """
    train = metric.campaign.train
    clean = metric.project(found.jacobian, np.ones(len(metric.nuisances), bool))[train]
    information = found.jacobian[train].T @ clean
    inverse = np.linalg.inv((information + information.T) / 2 + np.eye(clean.shape[1]) / PRIOR**2)
    score = clean * found.residual[train][:, None]
    clusters = [window_numbers(metric)[train], metric.campaign.recording_of[train]]
    if metric.campaign.subject.repeat is not None:
        clusters.append(moments(metric, metric.campaign.subject.repeat)[train])
    return np.sqrt(robust_variance(inverse, score, clusters))


def across(found: Scored, before: float) -> Scored:
    """With wider deviations of knobs whose cost has many minima: derivatives tell of one, model error decides which.

    A size that leaves no more than the best and the share of the gap that the model itself may (`System.slack`) is as
    good.
    """
    metric, candidate, at = found.metric, found.fit.candidate, found.fit.coordinates
    train, deviation = metric.campaign.train, found.deviation.copy()
    enough = found.train + metric.campaign.subject.slack * (before - 1)
    for k, (owner, *_) in enumerate(candidate.knobs):
        if candidate.effects[owner].rungs:
            moves = at[k] * np.r_[LOOKS, -LOOKS]
            looks = metric.predict([candidate.at(at + move * np.eye(len(at))[k]) for move in moves], training_only=True)
            as_good = [gap(metric.clean(metric.residual(look)), train) < enough for look in looks]
            deviation[k] = max(deviation[k], np.max(np.abs(moves), where=as_good, initial=0.0) / normal.ppf(SURE))
    return replace(found, deviation=deviation)


def window_numbers(metric: Metric) -> Array:
    """Number of the window of every entry, across recordings, (N,)."""
    campaign, window = metric.campaign, metric.campaign.subject.window
    per_recording = int(max(campaign.time) // window) + 1
    return (campaign.recording_of * per_recording + campaign.time // window).astype(int)


def moments(metric: Metric, repeat: float) -> Array:
    """Number of the window within its pass of every entry, alike in all passes of a motion that repeats, (N,)."""
    campaign = metric.campaign
    begin = np.array([campaign.subject.clock(log)[0] for log in campaign.recordings])
    return ((campaign.time + begin[campaign.recording_of]) % repeat // campaign.subject.window).astype(int)


@dataclass(frozen=True)
class Closure:
    """How much of the held-out gap above the floor went away, with a 95 % interval."""

    value: float
    low: float
    high: float


def closure(metric: Metric, before: Array, after: Array, rows: Array) -> Closure:
    """(gap before - gap after) / (gap before - 1), and its bootstrap over windows."""
    windows = window_numbers(metric)[rows]
    names, windows = np.unique(windows, return_inverse=True)
    size = np.bincount(windows)
    sums = [np.bincount(windows, r[rows] ** 2) for r in (before, after)]
    rng = np.random.default_rng(0)
    draws = np.vstack([np.arange(len(names)), rng.integers(len(names), size=(DRAWS, len(names)))])
    old, new = (np.sqrt(s[draws].sum(axis=1) / size[draws].sum(axis=1)) for s in sums)
    share = (old - new) / np.maximum(old - 1, 1e-9)
    low, high = np.quantile(share[1:], [0.025, 0.975])
    return Closure(float(share[0]), float(low), float(high))


def worse_by(metric: Metric, better: Array, worse: Array, rows: Array) -> tuple[float, float]:
    """Mean square of one residual less that of another, and the standard error of that difference over windows."""
    windows = window_numbers(metric)[rows]
    difference = (worse[rows] ** 2) - (better[rows] ** 2)
    sums = np.bincount(windows, difference)
    sums = sums[np.bincount(windows) > 0]
    return float(difference.mean()), float(np.sqrt(np.sum((sums - sums.mean()) ** 2)) / len(difference))
