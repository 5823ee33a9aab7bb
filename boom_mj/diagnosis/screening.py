"""Screening: which candidates are worth a fit, by the sensitivity of the simulated recordings to them.

For the probes of a candidate the columns J = f(probe) - f(0) are simulated at the roughest level; in the inner product
of the metric the best weights are w = (J^T J + 1 / W^2)^-1 J^T r, and they explain the share J^T r . w / <r, r> of the
training misfit. All candidates go in one batch, and with them what follows freely, so that what the two have in common
is known: the nuisances, and the effects that the machine has already.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from boom_mj.diagnosis.candidate import Candidate, apart
from boom_mj.diagnosis.fitting import PRIOR
from boom_mj.diagnosis.linearisation import Metric, coarsely, with_courses
from boom_mj.effects import Effect

Array = np.ndarray
WIDEST = 10.0  # prior deviation of a probe's weight
LINES = 3  # spectral lines offered to periodic effects
ALIKE = 0.9  # of the largest share of all, from which other probes of a candidate are starts too,
APART = 0.5  # if they differ by more of a size worth finding
LEFT = 0.25  # of a gap, by a course


@dataclass(frozen=True)
class Screened:
    """A candidate at the values that screening suggests, and the share of the training misfit that it may explain.

    Attributes:
        others: the same causes at other values that promise as much: fits have a minimum for each of many periods.
    """

    candidate: Candidate
    share: float
    others: tuple[Candidate, ...] = ()

    @property
    def starts(self) -> tuple[Candidate, ...]:
        """All from which a fit may begin."""
        return self.candidate, *self.others


class Signatures:
    """Sensitivity columns of every candidate about a machine, simulated once.

    Args:
        metric: of that machine.
        kinds: effects and places.
        lines: frequencies (Hz) offered to periodic effects.
        given: effects that the machine has already, free to change.
    """

    def __init__(
        self,
        metric: Metric,
        kinds: Sequence[tuple[type[Effect], dict]],
        lines: Sequence[float],
        given: tuple[Effect, ...] = (),
    ):
        self.metric, self.given = metric, given
        free = [(kind, place) for kind, place in kinds if apart(kind, place, given)]
        self.rows = [(kind, place, group) for kind, place in free for group in kind.probes(place, lines) if group]
        campaign, subject = metric.campaign, metric.campaign.subject
        probes = [kind(place, **probe) for kind, place, group in self.rows for probe in group]
        known, train, level = Candidate(given), campaign.train, subject.fidelity.rough
        steps, moved = known.steps(known.start)
        nuisances = [(*given, *t.hypothesis) for t in metric.nuisances]
        loose = [*nuisances, *moved]
        short = {probe: column for probe in probes if (column := subject.shortcut(probe))}
        long = [probe for probe in dict.fromkeys(probes) if probe not in short]
        whole = [given, *loose, *((*given, probe) for probe in long)]
        found = campaign.predictions(whole, level, training_only=True)
        base = next(found)
        changes = np.nan_to_num([next(found) - base for _ in loose]).reshape(len(loose), len(base)).T
        rough = replace(metric, columns=changes[:, : len(nuisances)] * [t.deviation for t in metric.nuisances])
        known_columns = [metric.white(change)[train] / s for change, s in zip(changes.T[len(nuisances) :], steps)]
        self.follow = np.column_stack([rough.taught, *known_columns])
        columns = {probe: column(rough)[train] for probe, column in short.items()}
        columns |= {probe: metric.white(prediction - base)[train] for probe, prediction in zip(long, found)}
        self.columns = np.stack([columns[p] for p in probes], axis=1, dtype=np.float32)  # (training, c)
        ends = np.cumsum([0, *(len(group) for _, _, group in self.rows)])
        self.stretches = [slice(start, stop) for start, stop in pairwise(ends)]

    def rank(self, residual: Array) -> list[Screened]:
        """Candidates by the share of a whitened residual that they may explain, best first, each at its best probe."""
        metric, train = self.metric, self.metric.campaign.train
        estimate = metric.estimate(residual)
        left = residual[train] - metric.taught @ estimate
        count, free = len(estimate), metric.free(estimate)  # a nuisance at its limit does not follow
        prior = np.r_[np.ones(count), np.full(self.follow.shape[1] - count, PRIOR**-2)]
        follow, prior = (part[..., np.r_[free, np.ones(len(prior) - count, bool)]] for part in (self.follow, prior))
        across = follow.T @ self.columns  # (k, c)
        following = np.linalg.solve(np.diag(prior) + follow.T @ follow, across)
        slopes, whole = left @ self.columns - (left @ follow) @ following, float(left @ left)
        found: dict[tuple, list[Screened]] = {}
        for (kind, place, group), part in zip(self.rows, self.stretches):
            square = self.columns[:, part].T @ self.columns[:, part] - across[:, part].T @ following[:, part]
            curvature = square + np.eye(len(group)) / WIDEST**2
            weights = np.linalg.solve(curvature, slopes[part])
            values = kind.blend(group, weights)
            candidate = Candidate((kind(place, **values),))
            share = float(slopes[part] @ weights / whole) if _acts(kind, values) else 0.0
            share = max(share, self._of_course(candidate, residual))
            found.setdefault(candidate.places, []).append(Screened(candidate, share))
        least = ALIKE * max((s.share for alike in found.values() for s in alike), default=0.0)
        ranked = []
        for alike in found.values():
            best, *others = sorted(alike, key=lambda s: -s.share)
            starts = [best.candidate]
            for other in (s.candidate for s in others if s.share > least):
                if all(np.max(np.abs(other.start - start.start)) > APART for start in starts):
                    starts.append(other)
            ranked.append(replace(best, others=tuple(starts[1:])))
        return sorted(ranked, key=lambda s: -s.share)

    def _of_course(self, candidate: Candidate, residual: Array) -> float:
        """The share of a whitened residual that a course in time of a candidate would explain, if it has one.

        Only one that leaves little counts.
        """
        metric, train = coarsely(self.metric), self.metric.campaign.train
        own = with_courses(metric, (*self.given, *candidate.effects), training_only=True)
        if own.courses is None or metric.courses is not None:
            return 0.0
        left = metric.clean(residual)
        before, after = (float(np.mean(white[train] ** 2)) for white in (left, own.courses.without(left)))
        return 1 - after / before if after**0.5 - 1 < LEFT * (before**0.5 - 1) else 0.0


def spectral_lines(metric: Metric, residual: Array, count: int = LINES) -> list[float]:
    """Frequencies (Hz) that stand out of the whitened channels that listen, in every training recording."""
    campaign, total = metric.campaign, None
    grid = np.arange(0.1, 3.0, 0.005)
    for number, channel in enumerate(campaign.channels):
        if channel.signal == campaign.subject.listening and channel.recording in campaign.learning:
            part = residual[campaign.stretch(number)]
            part = part - part.mean()
            phase = np.exp(-2j * np.pi * grid[:, None] * channel.time[None, :])
            power = np.abs(phase @ (part * np.hanning(len(part)))) ** 2 / (part @ part + 1)
            total = power if total is None else total + power
    if total is None:
        return []
    peaks = np.flatnonzero((total[1:-1] > total[:-2]) & (total[1:-1] >= total[2:])) + 1
    return [float(grid[k]) for k in peaks[np.argsort(-total[peaks])][:count]]


def _acts(kind: type[Effect], values: dict[str, float]) -> bool:
    """Whether any of the values is off neutral: one-sided bounds may forbid what the weights ask for."""
    knobs = kind.parameters
    return any(v != knobs[name].neutral and abs(knobs[name].coordinate(v)) > 1e-6 for name, v in values.items())
