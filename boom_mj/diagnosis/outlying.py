"""Outliers: a sensor, or a few seconds of a recording, that no explanation fits where one fits all the rest.

Squares let one loose plug, or one knock at the boom, outvote all other sensors. Where a search ends without an
explanation and one part of the data holds most of the gap's excess above noise, it is made anew without that part. The
part itself stays unexplained, whatever the rest says.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from boom_mj.diagnosis.linearisation import Linearisation
from boom_mj.diagnosis.refining import near
from boom_mj.diagnosis.scoring import Scored
from boom_mj.estimation.bootstrap import gap
from boom_mj.estimation.dataset import Dataset
from boom_mj.estimation.intervals import FEWEST
from boom_mj.estimation.least_squares import OPTIONS
from boom_mj.replay.quality import Action, DataFinding

Array = np.ndarray
MOST = 2  # parts that are left out: each costs a search, and what needs more is no outlier
MAJORITY = 3  # sensors at least, for one of them to be outvoted


@dataclass(frozen=True, eq=False)
class _Part:
    """Of the data.

    Attributes:
        device: the sensor that is meant, "" for all.
        rows: entries, (N,) of bool.
        whole: whether all is meant that the sensor says.
    """

    device: str
    rows: Array
    whole: bool


@dataclass(frozen=True, eq=False)
class Outlier(_Part):
    """Such a part.

    Attributes:
        data: whose entries.
        gap: what every explanation leaves of it at least.
    """

    data: Dataset
    gap: float

    @property
    def spans(self) -> dict[int, tuple[float, float]]:
        """By index of a recording when it begins and ends, s."""
        found = {}
        for index in np.unique(self.data.recording_of[self.rows]).tolist():
            time = self.data.time[self.rows & (self.data.recording_of == index)]
            found[index] = time.min() - self.data.block_s / 2, time.max() + self.data.block_s / 2
        return found

    @property
    def name(self) -> str:
        """In words."""
        times = (f"{self.data.recordings[k].name} from {a:.4g} to {b:.4g} s" for k, (a, b) in self.spans.items())
        device = self.device or "all sensors"
        return device if self.whole else f"{device} of {' and '.join(times)}"

    @property
    def findings(self) -> list[DataFinding]:
        """One of every recording."""
        findings = []
        for index, (begin, end) in self.spans.items():
            when = "" if self.whole else f"from {begin:.1f} to {end:.1f} s "
            text = f"is {when}at least {self.gap:.1f} times its noise off, whatever explains the rest"
            log = self.data.recordings[index].name
            findings.append(DataFinding(log, self.device, "outlying", begin, end, text, Action.LEFT_OUT, used=False))
        return findings


def outlying(model: Linearisation, as_built: Array, scored: Sequence[Scored]) -> Outlier | None:
    """What holds most of a gap's excess above noise and leaves little without it, if anything does.

    Where the floor is never reached (`gain_z`), what some explanation closes most of is none: a cause is at work there.

    Args:
        as_built: whitened residual of the machine as built, (N,).
        scored: explanations that were tried.
    """
    data, criteria, before = model.data, model.criteria, gap(as_built, model.data.held_out)
    most = near(model, before)
    residuals = [as_built, *(one.fit.residual for one in scored)]
    parts: list[tuple[float, _Part]] = []
    for residual, found in zip(residuals, [None, *scored]):
        for part in _suspects(model, residual):
            looks = [(residual, data.used)]
            if found:
                looks.append((_refitted(found, data.train & ~part.rows), data.train))
            for left, rows in looks:
                off, rest = rows & part.rows, rows & ~part.rows
                own, all_of_it = (float(np.sum(left[some] ** 2 - 1)) for some in (off, rows))
                worst = float(np.nanmax([gap(left, rest & data.train), gap(left, rest & data.held_out)]))
                holds = gap(left, off) > criteria.near_noise_gap and own > (1 - model.budget.far) * all_of_it
                if holds and worst <= most:
                    parts.append((worst, part))
    best = min((left for left, _ in parts), default=0.0)
    alike = [part for left, part in parts if left - best <= criteria.tie_closure * (before - 1)]
    for part in sorted(alike, key=lambda part: part.rows.sum()):
        least = min(gap(residual, part.rows) for residual in residuals)
        tells = len(np.unique(data.windows[data.held_out & ~part.rows])) >= FEWEST
        enough = near(model, gap(as_built, part.rows)) if criteria.gain_z else criteria.near_noise_gap
        if tells and least > enough:
            return Outlier(part.device, part.rows, part.whole, data, least)
    return None


def _refitted(found: Scored, rows: Array) -> Array:
    """The residual of a fit, (N,), as a fit to some of its training rows, (N,) of bool, would leave it in training."""
    posterior, jacobian = found.model.posterior, found.fit.jacobian
    felt = posterior.project(jacobian, np.ones(len(posterior.some), bool))  # while nuisances follow
    own = felt[rows].astype(float)
    information = own.T @ own + np.eye(own.shape[1]) / OPTIONS.prior**2
    return found.fit.residual - felt @ np.linalg.solve(information, own.T @ found.fit.residual[rows])


def _suspects(model: Linearisation, residual: Array) -> Iterator[_Part]:
    """The sensor with most excess, and the recording's moments: of either those that are off, if they are but few."""
    data, channels = model.data, model.data.channels
    devices = [model.system.channel(channel.signal, channel.column).device for channel in channels]
    names, number = np.unique(devices, return_inverse=True)
    excess = np.where(data.used, residual**2 - 1, 0.0)
    if len(names) >= MAJORITY:
        worst = int(np.argmax(np.bincount(number[data.channel_of], excess)))
        own = data.used & (number[data.channel_of] == worst)
        few = _off(model, residual, own)
        yield _Part(str(names[worst]), own if few is None else few, few is None)
    index = int(np.argmax(np.bincount(data.recording_of, excess)))
    few = _off(model, residual, data.used & (data.recording_of == index))
    if few is not None:
        yield _Part("", few, False)


def _off(model: Linearisation, residual: Array, rows: Array) -> Array | None:
    """Entries of those windows of some (N,) of bool that are off beyond noise and chance; None if half of them are."""
    windows, criteria = model.data.windows, model.criteria
    size = int(windows.max()) + 1
    count = np.bincount(windows[rows], minlength=size)
    square = np.bincount(windows[rows], residual[rows] ** 2, size) / np.maximum(count, 1)
    by_chance = 1 + criteria.sure_z * np.sqrt(2 / np.maximum(count, 1))
    off = square > np.maximum(criteria.near_noise_gap**2, by_chance)
    few = off.sum() < criteria.main_share * (count > 0).sum()
    return rows & off[windows] if few and off.any() else None
