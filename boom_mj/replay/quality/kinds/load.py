"""Known loads in another unit, or not logged."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from boom_mj.errors import BoomError
from boom_mj.recording import UNITS, Recording, named_signal
from boom_mj.replay.quality.check import Check, Found, Turn
from boom_mj.replay.quality.edits import DRIVE, mapped
from boom_mj.replay.quality.evidence import Evidence
from boom_mj.replay.quality.finding import Action, Repair
from boom_mj.replay.quality.kinds.unit import OFF, named_unit
from boom_mj.replay.replay import replay

Array = np.ndarray
LOAD, ROPE = "load", 1000.0  # N, of a rope that is tried where none is logged
BEFORE, AFTER = 3.0, 2.0  # s around a cut rope: later a model that is a little wrong is out of step
EXPLAINED = 0.4  # of what the model leaves about its means, by a rope; true ones reach 0.5 to 0.9
BLOW = 20.0  # times an accelerometer's noise, from one sample to the next, where nothing else moves: a cut rope
MARKERS, CYLINDERS = "markers", "cylinder/"
ALIKE = 0.3  # of a factor, within which both say the same: they are not in another unit both
CLIP = 1e4  # in noise: what is in another unit must not drown the rest
WEAK = 1e-3  # N, below which a logged load is none


class Load(Check):
    """What a load does is linear in it: measured less predicted without it, against predicted with it less without.

    The factor is 1 for a load in N, about 1000 for one in kN, -1 for one pulled the other way. Where a recording that
    logs no load starts to swing at rest, ropes cut at that moment are tried.
    """

    kind = "load"
    turn = Turn.LOADS

    def look(self, evidence: Evidence) -> Iterator[Found]:
        acts: dict[int, tuple[float, float]] = {}
        for index in evidence.indices:
            log = evidence.recordings[index]
            if LOAD in log and np.ptp(log[LOAD].values, axis=0).max() > WEAK:
                acts[index] = _acts(evidence, index)
            elif DRIVE in log and (cut := _blow(evidence, index)) is not None:
                yield from self._missing(evidence, index, cut)
        shown = {k: change for k, (factor, told) in acts.items() if (change := _change(factor, told)) is not None}
        sound = any(told > EXPLAINED and 1 / OFF < factor < OFF for factor, told in acts.values())
        for index, (factor, _) in acts.items():
            change = shown.get(index) or (None if sound else next(iter(shown.values()), None))
            if change is not None:
                yield self._wrong(evidence, index, change, factor if index in shown else None)

    def _wrong(self, evidence: Evidence, index: int, change: tuple[str, float], factor: float | None) -> Found:
        word, times = change
        if factor is None:
            text = "is in the unit of the other logs" if word else "is turned as in the other logs"
        elif word:
            text = f"acts {factor:.4g} times as strongly as logged, as if in {word} instead of N"
        else:
            text = "acts the other way round"
        repair = Repair(LOAD, unit=word) if word in UNITS["N"] else None if word else Repair(LOAD, sign=-1)
        finding = evidence.finding(self.kind, index, LOAD, text, Action.REPAIRED, True, repair=repair)
        return Found(index, finding, mapped(LOAD, np.full(3, times), np.zeros(3)))

    def _missing(self, evidence: Evidence, index: int, cut: float) -> Iterator[Found]:
        log, plain = evidence.recordings[index], evidence.twin(index)
        if plain is None:
            return
        tried = [_rope(evidence, log, plain.twin, moment) for moment in (cut, cut + _step(log))]
        if max(tried) < EXPLAINED:
            return
        text = f"is not logged: from {cut - evidence.start(index):.2f} s on the boom swings as if a rope had been cut"
        part = range(evidence.training) if index < evidence.training else range(evidence.training, len(evidence.names))
        others = any(k in part for k in evidence.indices if k != index)
        action = Action.LEFT_OUT if others else Action.SAID
        finding = evidence.finding(self.kind, index, LOAD, text, action, False)
        yield Found(index, finding, leave_out=others)


def _acts(evidence: Evidence, index: int) -> tuple[float, float]:
    """How many times as strongly as logged a load acts, and the share of what happens without it that this explains."""
    log, whole = evidence.recordings[index], evidence.twin(index)
    without = _twin(evidence, log.with_signals({LOAD: replace(log[LOAD], values=0 * log[LOAD].values)}))
    if without is None or whole is None:
        return 1.0, 0.0
    cut = float(log[LOAD].time[int(np.argmax(np.abs(np.diff(log[LOAD].values, axis=0)).max(axis=1)))])
    every, markers, force = (_share(evidence, log, without, whole.twin, cut, only) for only in ("", MARKERS, CYLINDERS))
    if abs(markers[0] - force[0]) < ALIKE * abs(markers[0]):  # late IMUs put their jolts beside those of the model
        return max(every, min(markers, force, key=lambda one: one[1]), key=lambda one: one[1])
    return every


def _share(
    evidence: Evidence, log: Recording, without: Recording, whole: Recording, cut: float, only: str
) -> tuple[float, float]:
    """Factor and share, see `_acts`, by sensors of some names only."""
    rest, effect = (_about(evidence, one, without, log, cut, only) for one in (log, whole))
    square = max(float(effect @ effect), 1e-300)
    factor = float(rest @ effect) / square
    return factor, factor**2 * square / max(float(rest @ rest), 1e-300)


def _change(factor: float, told: float) -> tuple[str, float] | None:
    """Unit that a load is in, "" for a turned one, and by what to multiply it; None for a sound one."""
    if told < EXPLAINED or not factor:
        return None
    if 1 / OFF < -factor < OFF:
        return "", -1.0
    return named_unit("N", 1 / abs(factor))


def _twin(evidence: Evidence, log: Recording) -> Recording | None:
    try:
        return replay(evidence.plant, log).twin
    except BoomError:
        return None


def _about(evidence: Evidence, one: Recording, other: Recording, log: Recording, cut: float, only: str = "") -> Array:
    """one - other of all sensors in noise around a cut, about its mean in every channel, (N,); 0 where not known."""
    parts = [np.zeros(0)]
    for name, level in evidence.levels.items():
        if name == DRIVE or not name.startswith(only) or name not in log or name not in one or name not in other:
            continue
        near = (log[name].time > cut - BEFORE) & (log[name].time < cut + AFTER)
        difference = (one[name].values - other[name].values)[near] / level
        alive = np.isfinite(log[name].values)[near]
        count = np.maximum(alive.sum(axis=0), 1)
        difference = np.where(alive, difference, 0.0)
        difference = np.where(alive, difference - difference.sum(axis=0) / count, 0.0)
        parts.append(np.clip(difference, -CLIP, CLIP).ravel() if one is log else difference.ravel())
    return np.concatenate(parts)


def _step(log: Recording) -> float:
    return float(np.median(np.diff(log[DRIVE].time)))


def _rope(evidence: Evidence, log: Recording, plain: Recording, cut: float) -> float:
    """Share of what the model leaves that a rope explains which is cut at a moment."""
    rest, columns, time = _about(evidence, log, plain, log, cut), [], log[DRIVE].time
    for axis in range(3):
        pull = np.where(time[:, None] < cut, ROPE * np.eye(3)[axis], 0.0)
        twin = _twin(evidence, log.with_signals({LOAD: named_signal(LOAD, time, pull)}))
        if twin is None:
            return 0.0
        columns.append(_about(evidence, twin, plain, log, cut))
    effect = np.stack(columns, axis=1)
    force, *_ = np.linalg.lstsq(effect, rest, rcond=None)
    left = rest - effect @ force
    return 1 - float(left @ left) / max(float(rest @ rest), 1e-300)


def _blow(evidence: Evidence, index: int) -> float | None:
    """When accelerometers jump although every joint rests, stamp in s."""
    log = evidence.recordings[index]
    joints = log[DRIVE]
    jumps = []
    for name in evidence.measured(index):
        if name.endswith("specific_force"):
            signal = log[name]
            step = np.abs(np.diff(signal.values, axis=0)) / evidence.noise(name)
            jumps.append((signal.time[1:], np.nanmax(np.nan_to_num(step), axis=1)))
    if not jumps:
        return None
    time, size = max(jumps, key=lambda jump: jump[1].max())
    first = int(np.argmax(size > BLOW))
    if size[first] <= BLOW:
        return None
    around = np.abs(joints.time - time[first]) < 1.0
    still = np.ptp(joints.values[around], axis=0) < 10 * evidence.noise(DRIVE)
    return float(time[first]) if around.any() and still.all() else None
