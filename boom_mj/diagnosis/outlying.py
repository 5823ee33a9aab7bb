"""Outliers: a sensor, or a few seconds of a recording, that no explanation fits where one fits all the rest.

Squares rule least squares: one loose plug, one push at the boom outvote all other sensors. Before nothing is said to
explain a gap, its excess above noise is looked at: where one part of the data holds most of it, the search is made anew
without. That part is not explained, whatever the rest says.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from boom_mj.diagnosis.linearisation import Linearisation
from boom_mj.diagnosis.refining import near
from boom_mj.diagnosis.scoring import Scored
from boom_mj.estimation.bootstrap import gap
from boom_mj.estimation.dataset import Dataset
from boom_mj.estimation.intervals import FEWEST
from boom_mj.replay.quality import Action, DataFinding

Array = np.ndarray
MAJORITY = 3  # sensors at least, for one of them to be outvoted


@dataclass(frozen=True, eq=False)
class Outlier:
    """A part of the data.

    Attributes:
        device: the sensor that is meant, "" for all.
        rows: its entries, (N,) of bool.
        data: whose entries.
        gap: what every explanation leaves of it at least.
    """

    device: str
    rows: Array
    data: Dataset
    gap: float

    @property
    def whole(self) -> bool:
        """Whether a sensor is meant in all recordings."""
        return len(self.spans) == len(self.data.recordings)

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
        times = (f"{self.data.recordings[k].name} from {a:.0f} to {b:.0f} s" for k, (a, b) in self.spans.items())
        device = self.device or "all sensors"
        return device if self.whole else f"{device} of {' and '.join(times)}"

    @property
    def findings(self) -> list[DataFinding]:
        """One of every recording."""
        evidence = f"is {self.gap:.1f} times its noise off, whatever explains the rest"
        return [
            DataFinding(
                self.data.recordings[k].name, self.device, "outlying", a, b, evidence, Action.LEFT_OUT, used=False
            )
            for k, (a, b) in self.spans.items()
        ]


def outlying(model: Linearisation, as_built: Array, scored: Sequence[Scored]) -> Outlier | None:
    """What holds most of a gap's excess above noise and leaves little without it, if anything does.

    Args:
        as_built: whitened residual of the machine as built, (N,).
        scored: explanations that were tried.
    """
    data, before = model.data, gap(as_built, model.data.held_out)
    residuals = [as_built, *(one.fit.residual for one in scored)]
    parts = []
    for residual in residuals:
        for device, rows in _suspects(model, residual):
            rest = data.used & ~rows
            excess = [float(np.sum(residual[some] ** 2 - 1)) for some in (rows, data.used)]
            left = max(gap(residual, rest & data.train), gap(residual, rest & data.held_out))
            if excess[0] > model.criteria.main_share * excess[1] and left <= near(model, before):
                parts.append((left, device, rows))
    for _, device, rows in sorted(parts, key=lambda part: part[0])[:1]:
        least = min(gap(residual, rows) for residual in residuals)
        tells = len(np.unique(data.windows[data.held_out & ~rows])) >= FEWEST
        if tells and least > model.criteria.near_noise_gap:
            return Outlier(device, rows, data, least)
    return None


def _suspects(model: Linearisation, residual: Array) -> list[tuple[str, Array]]:
    """The sensor with most excess, and the recording's moments: of either those that are off, if they are but few."""
    data, found = model.data, []
    devices, number = np.unique(
        [model.system.channel(c.signal, c.column).device for c in data.channels], return_inverse=True
    )
    excess = np.where(data.used, residual**2 - 1, 0.0)
    if len(devices) >= MAJORITY:
        worst = int(np.argmax(np.bincount(number[data.channel_of], excess)))
        own = data.used & (number[data.channel_of] == worst)
        few = _off(model, residual, own)
        found.append((str(devices[worst]), own if few is None else few))
    index = int(np.argmax(np.bincount(data.recording_of, excess)))
    few = _off(model, residual, data.used & (data.recording_of == index))
    return found if few is None else [*found, ("", few)]


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
