"""Watching a machine: is it still what it was, since when not, and what changed.

The healthy recordings say how the machine was built and how large residuals are. Of every later recording the mean
square of each channel group is held against that: over windows of independence,

    z = (mean square - g^2 max(healthy mean, 1)) / (healthy deviation sqrt(1 / windows + 1 / healthy windows)),

with g = `near_noise_gap`, the gap up to which nothing is worth a look: model error differs from motion to motion. The
largest z of all groups is held against a limit that false alarms pass in FALSE_ALARMS of recordings, shared among the
groups. Within the first changed recording the change lies where windows that pass it in any group begin. What changed
is diagnosed on the one of the last two recordings that shows most, since a cause may grow from one to the next, or on
both where one does not tell; how large it is, in every recording by itself.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.special import stdtrit

from boom_mj.diagnosis.answer import plain
from boom_mj.diagnosis.clock import Clock
from boom_mj.diagnosis.conclusion import Diagnosis
from boom_mj.diagnosis.diagnose import diagnose
from boom_mj.diagnosis.growth import fitted_alone
from boom_mj.diagnosis.healthy import as_built
from boom_mj.diagnosis.linearisation import Linearisation, linearise
from boom_mj.diagnosis.named import described, located
from boom_mj.recording import Recording
from boom_mj.systems.predictor import Predictor, dataset_of
from boom_mj.systems.system import System

Array = np.ndarray
FALSE_ALARMS = 0.01  # of healthy recordings that are called changed, at most
LEAST_DEVIATION = 0.05  # of a healthy window's mean square: windows are too few to know it better


@dataclass(frozen=True)
class LogState:
    """One recording: whether the machine had changed, by what statistic against which limit, seen most where.

    `effects` holds the causes as large as this recording alone asks for; none where the change has no explanation, and
    where time was up.
    """

    log: str
    changed: bool
    statistic: float
    limit: float
    group: str
    effects: tuple[dict[str, Any], ...] = ()


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
        effects = _causes(self.found, described(self.found)) if self.found and self.found.best else []
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
    residual = model.residual(model.base)
    allowed, squares = model.criteria.near_noise_gap**2, _squares(model, model.clean(residual))
    states = []
    for index in range(len(healthy), len(healthy) + len(logs)):
        states.append(_state(model.data.recordings[index].name, squares, len(healthy), index, allowed))
        clock.tell(f"{states[-1].log}: {states[-1].statistic:.1f} of {states[-1].limit:.1f}, by {states[-1].group}")
    changed = [k for k, state in enumerate(states) if state.changed]
    if not changed:
        return Watch(tuple(states), None, None)
    first = changed[0]
    apart = model.data.measured - model.base - model.mean_error - model.columns @ model.posterior.estimate(residual)
    each = _squares(model, np.nan_to_num(apart) * model.noise.weight)  # the other is whitened all along a recording
    since = _moment(each, len(healthy), len(healthy) + first, allowed, model.data.correlation_s)
    shows = {k: states[k].statistic for k in changed[-2:]}
    most = max(shows, key=shows.__getitem__)
    found = _diagnosed(built, logs[most], [logs[k] for k in shows], since if most == first else 0.0, clock)
    if found.best and any(found.named):
        for k, state in enumerate(states):
            if clock.over(f"sizes in {state.log}"):
                break
            clock.tell(f"{state.log}: {found.best.label}")
            index, moment = len(healthy) + k, since if k == first else 0.0
            alone = fitted_alone(model, index, found.best.fit.effects, moment, state.changed, clock)
            states[k] = replace(state, effects=tuple(_causes(found, located(alone))))
    return Watch(tuple(states), (states[first].log, since), found)


def _causes(found: Diagnosis, effects: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """Of entries for all effects of the best explanation those that the verdict names."""
    return [effect for effect, so in zip(effects, found.named) if so]


def _diagnosed(built: System, log: Recording, last: Sequence[Recording], since_s: float, clock: Clock) -> Diagnosis:
    """Of a recording from a moment on, or, where that does not tell, of the last changed ones."""
    alone = diagnose(Predictor(built, dataset_of(built, [log], 1).alone(0, since_s)), clock=clock)
    if alone.solved or len(last) == 1 or clock.over("the last two changed recordings"):
        return alone
    clock.tell(" and ".join(one.name for one in last))
    both = diagnose(Predictor(built, dataset_of(built, last, 1)), clock=clock)
    return both if both.solved else alone


def _squares(model: Linearisation, residual: Array) -> dict[str, dict[int, Array]]:
    """`_windows` of all channel groups."""
    return {group: _windows(model, residual, group) for group in sorted({c.group for c in model.data.channels})}


def _windows(model: Linearisation, residual: Array, group: str) -> dict[int, Array]:
    """Mean squares of a channel group over windows of independence, by recording; NaN where less than half full."""
    data, found = model.data, {}
    own = data.spread([channel.group == group for channel in data.channels]).astype(bool) & data.used
    for index in range(len(data.recordings)):
        rows = own & (data.recording_of == index)
        if rows.any():
            window = (data.time[rows] // data.correlation_s).astype(int)
            samples = np.bincount(window)
            whole = samples >= samples.max() / 2  # what is over at the end is a sample or two, and scatters more
            squares = np.bincount(window, residual[rows] ** 2) / np.maximum(samples, 1)
            found[index] = np.where(whole, squares, np.nan)
    return found


def _excess(squares: dict[int, Array], healthy: int, index: int, allowed: float) -> tuple[Array, int]:
    """What windows have too much, in deviations of healthy ones, (n,) with NaN, and how many healthy ones there are."""
    base = np.concatenate([values for k, values in squares.items() if k < healthy] or [np.ones(1)])
    base = base[np.isfinite(base)]
    deviation = max(float(np.std(base, ddof=1)) if len(base) > 1 else 1.0, LEAST_DEVIATION)
    return (squares[index] - allowed * max(base.mean(), 1.0)) / deviation, len(base)


def _limit(base: int, groups: int) -> float:
    """Deviations that chance exceeds in FALSE_ALARMS of cases, in any of some groups, by so many healthy windows."""
    return float(stdtrit(max(base - 1, 1), 1 - FALSE_ALARMS / groups))


def _state(name: str, squares: dict[str, dict[int, Array]], healthy: int, index: int, allowed: float) -> LogState:
    best, group, limits = -np.inf, "", [0.0]
    there = [name for name, by_log in squares.items() if index in by_log]
    for one in there:
        excess, base = _excess(squares[one], healthy, index, allowed)
        windows = np.isfinite(excess).sum()
        z = float(np.nanmean(excess) / np.sqrt(1 / windows + 1 / base))
        limits.append(_limit(base, len(there)))
        if z > best:
            best, group = z, one
    limit = max(limits)
    return LogState(name, best > limit, best, limit, group)


def _moment(squares: dict[str, dict[int, Array]], healthy: int, index: int, allowed: float, window_s: float) -> float:
    """From when on windows show most, s: k with the largest sum of v over sqrt(n - k), of n windows the n - k last.

    v is 1 where any group is beyond its limit; where none is in any window, the largest excess.
    """
    there = [by_log for by_log in squares.values() if index in by_log]
    most, beyond = np.zeros((2, max(len(by_log[index]) for by_log in there)))
    for by_log in there:
        excess, base = _excess(by_log, healthy, index, allowed)
        own, limit = slice(len(excess)), _limit(base, len(there)) * np.sqrt(1 + 1 / base)
        most[own] = np.fmax(most[own], excess)
        beyond[own] = np.fmax(beyond[own], excess > limit)
    shown = beyond if beyond.any() else most
    rest = np.cumsum(shown[::-1])[::-1]
    return float(np.argmax(rest / np.sqrt(np.arange(len(rest), 0, -1))) * window_s)
