"""Watching a machine: is it still what it was, since when not, and what changed.

The healthy recordings say how the machine was built and how large residuals are. Of every later recording the mean
square of each channel group is held against that: over windows of independence,

    z = (mean square - g^2 max(healthy mean, 1)) / (healthy deviation sqrt(1 / windows + 1 / healthy windows)),

with g = `near_noise_gap`, the gap up to which nothing is worth a look: model error differs from motion to motion. The
largest z of all groups is held against a limit that false alarms pass in FALSE_ALARMS of recordings, shared among the
groups. Within the first changed recording the change lies where the cumulative sum of what is too much, of the group
that shows most, begins to rise for good.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.special import stdtrit

from boom_mj.diagnosis.answer import plain
from boom_mj.diagnosis.clock import Clock
from boom_mj.diagnosis.diagnose import Diagnosis, diagnose
from boom_mj.diagnosis.healthy import as_built
from boom_mj.diagnosis.linearisation import Linearisation, linearise
from boom_mj.diagnosis.named import described
from boom_mj.recording import Recording
from boom_mj.systems.predictor import Predictor, dataset_of
from boom_mj.systems.system import System

Array = np.ndarray
FALSE_ALARMS = 0.01  # of healthy recordings that are called changed, at most
LEAST_DEVIATION = 0.05  # of a healthy window's mean square: windows are too few to know it better


@dataclass(frozen=True)
class LogState:
    """One recording: whether the machine had changed, by what statistic against which limit, seen most where."""

    log: str
    changed: bool
    statistic: float
    limit: float
    group: str


@dataclass(frozen=True)
class Watch:
    """What became of a machine.

    Attributes:
        logs: in the order of their time.
        since: name of the first changed recording, and when in it, s from its start; None if nothing changed.
        found: the diagnosis of what changed.
    """

    logs: tuple[LogState, ...]
    since: tuple[str, float] | None
    found: Diagnosis | None

    def document(self) -> dict[str, Any]:
        """As plain data."""
        since = None if self.since is None else dict(zip(("log", "time_s"), self.since))
        effects = described(self.found) if self.found and self.found.solved else []
        verdict = self.found.verdict if self.found else "consistent"
        return plain({"logs": [vars(one) for one in self.logs], "since": since, "verdict": verdict, "effects": effects})


def watch(system: System, healthy: Sequence[Recording], logs: Sequence[Recording], clock: Clock | None = None) -> Watch:
    """Hold recordings in the order of their time against healthy ones.

    Args:
        clock: how much time there is, and who hears one line per stage.
    """
    clock = clock or Clock()
    built = as_built(system, healthy, clock)
    model = linearise(Predictor(built, dataset_of(built, [*healthy, *logs], len(healthy))))
    residual = model.clean(model.residual(model.base))
    allowed = model.criteria.near_noise_gap**2
    squares = {group: _windows(model, residual, group) for group in sorted({c.group for c in model.data.channels})}
    states = []
    for index in range(len(healthy), len(healthy) + len(logs)):
        states.append(_state(model.data.recordings[index].name, squares, len(healthy), index, allowed))
        clock.tell(f"{states[-1].log}: {states[-1].statistic:.1f} of {states[-1].limit:.1f}, by {states[-1].group}")
    changed = [k for k, state in enumerate(states) if state.changed]
    if not changed:
        return Watch(tuple(states), None, None)
    first = changed[0]
    since = _moment(squares[states[first].group], len(healthy), len(healthy) + first, model.data.correlation_s)
    altered = [logs[k] for k in changed]
    train = max(1, len(altered) - 1)
    found = diagnose(Predictor(built, dataset_of(built, altered, train)), clock=clock)
    return Watch(tuple(states), (states[first].log, since), found)


def _windows(model: Linearisation, residual: Array, group: str) -> dict[int, Array]:
    """Mean squares of a channel group over windows of independence, by recording; at least half full ones."""
    data, found = model.data, {}
    own = data.spread([channel.group == group for channel in data.channels]).astype(bool) & data.used
    for index in range(len(data.recordings)):
        rows = own & (data.recording_of == index)
        if rows.any():
            _, windows, samples = np.unique(data.windows[rows], return_inverse=True, return_counts=True)
            whole = samples >= samples.max() / 2  # what is over at the end is a sample or two, and scatters more
            found[index] = (np.bincount(windows, residual[rows] ** 2) / samples)[whole]
    return found


def _healthy(squares: dict[int, Array], healthy: int) -> Array:
    """Of all healthy recordings."""
    return np.concatenate([values for index, values in squares.items() if index < healthy] or [np.ones(1)])


def _state(name: str, squares: dict[str, dict[int, Array]], healthy: int, index: int, allowed: float) -> LogState:
    best, group, limits = -np.inf, "", [0.0]
    there = [name for name, by_log in squares.items() if index in by_log]
    for one in there:
        base, now = _healthy(squares[one], healthy), squares[one][index]
        deviation = max(float(np.std(base, ddof=1)) if len(base) > 1 else 1.0, LEAST_DEVIATION)
        z = (now.mean() - allowed * max(base.mean(), 1.0)) / (deviation * np.sqrt(1 / len(now) + 1 / len(base)))
        limits.append(float(stdtrit(max(len(base) - 1, 1), 1 - FALSE_ALARMS / len(there))))
        if z > best:
            best, group = float(z), one
    limit = max(limits)
    return LogState(name, best > limit, best, limit, group)


def _moment(squares: dict[int, Array], healthy: int, index: int, window_s: float) -> float:
    """When the cumulative sum of a recording's excess begins to rise for good, s."""
    base, now = _healthy(squares, healthy), squares[index]
    excess = now - (base.mean() + now.mean()) / 2
    total = np.concatenate([[0.0], np.cumsum(excess)])
    return float(np.argmin(total) * window_s)
