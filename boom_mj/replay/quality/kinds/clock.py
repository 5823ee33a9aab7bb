"""Clocks that jump, run at another pace, or are late with the joints."""

from collections.abc import Iterator
from functools import partial

import numpy as np

from boom_mj.replay.quality.beside import expected
from boom_mj.replay.quality.check import Check, Found, Turn
from boom_mj.replay.quality.edits import COMMAND, DRIVE, restamped
from boom_mj.replay.quality.evidence import Evidence
from boom_mj.replay.quality.finding import Action

Array = np.ndarray
LATE_STEPS = 1.5  # of a sensor, by which it ends after the others; in sound logs all end within one
JUMP = 1.4  # usual steps, from which on a step may be a clock's jump
PACE = 1e-4  # by which a clock may run too fast or too slow; crystals keep to a fifth of it
FASTEST = 0.05  # beyond it the rate is another
ALIKE = 0.4  # how far what a jump or pace explains may be from how much later the sensor ends


class ClockJumps(Check):
    """A sensor whose stamps leap at a step and that ends later than the others by that leap: no message is missing."""

    kind = "clock"
    turn = Turn.STAMPS

    def look(self, evidence: Evidence) -> Iterator[Found]:
        for index in evidence.indices:
            log = evidence.recordings[index]
            for sensor, names in evidence.sensors(index).items():
                time, late = log[names[0]].time, _later(evidence, index, sensor)
                if len(time) < 20 or late is None:
                    continue
                step = np.diff(time)
                usual, at = float(np.median(step)), int(np.argmax(step))
                leap = float(step[at]) - usual
                if leap < (JUMP - 1) * usual or late < LATE_STEPS * usual or abs(late - leap) > ALIKE * leap + usual:
                    continue
                when = float(time[at])
                text = f"stamps leap by {leap:.3f} s and no message is missing: it ends {late:.3f} s after the others"
                finding = evidence.finding(
                    self.kind, index, sensor, text, Action.REPAIRED, True, (when, float(time[-1]))
                )
                yield Found(index, finding, restamped(names, partial(_without_leap, when, leap)))


class ClockPace(Check):
    """A sensor whose steps are not the machine file's, and that ends as much later, or earlier, than the others.

    A sensor that merely samples at another rate ends with the others. What one recording shows, the others have too
    where their steps are the same.
    """

    kind = "clock"
    turn = Turn.STAMPS

    def look(self, evidence: Evidence) -> Iterator[Found]:
        paces: dict[str, dict[int, float]] = {}
        shown: dict[str, float] = {}
        for index in evidence.indices:
            for sensor, names in evidence.sensors(index).items():
                time, late = evidence.recordings[index][names[0]].time, _later(evidence, index, sensor)
                rate = evidence.rates.get(names[0], 0.0)
                if len(time) < 20 or late is None or not rate:
                    continue
                usual = float(np.median(np.diff(time)))
                pace = usual * rate
                slip = float(time[-1] - time[0]) * (1 - 1 / pace)
                if abs(pace - 1) > PACE and abs(pace - 1) < FASTEST:
                    paces.setdefault(sensor, {})[index] = pace
                    if abs(late) > usual / 2 and abs(late - slip) < ALIKE * abs(slip) + usual / 2:
                        shown[sensor] = pace
        for sensor, pace in shown.items():
            for index, own in paces[sensor].items():
                if abs(own - pace) > ALIKE * abs(pace - 1):
                    continue
                text = f"stamps run {1e3 * (own - 1):+.3f} per mille too fast, away from those of the other sensors"
                finding = evidence.finding(self.kind, index, sensor, text, Action.REPAIRED, True)
                names = evidence.sensors(index)[sensor]
                yield Found(index, finding, restamped(names, partial(_slower, own)))


def _without_leap(when: float, leap: float, time: Array) -> Array:
    return np.where(time > when, time - leap, time)


def _slower(pace: float, time: Array) -> Array:
    return time[0] + (time - time[0]) / pace


def _earlier(late: float, time: Array) -> Array:
    return time - late


def _later(evidence: Evidence, index: int, sensor: str) -> float | None:
    """How much later than the others a sensor ends, s; None where it is alone."""
    log = evidence.recordings[index]
    ends = {s: float(log[names[0]].time[-1]) for s, names in evidence.sensors(index).items()}
    others = [end for other, end in ends.items() if other != sensor]
    return ends[sensor] - float(np.median(others)) if others else None


LAGS = np.arange(-0.6, 0.601, 0.06)  # s
BEHIND = 0.02  # s, by which a joint is behind its command; sound ones by less than 1 ms
ALONE = 0.15  # s, by which sensors must precede where no command tells; effects make 0.08 of it
SWING = np.radians(3.0)  # of a command, for a lag to be read off it
SURE = 5.0  # standard deviations by which a lag must fit better than none: channels that are noise have one, too
STREAMS = ("imu/", "markers")


class JointsLate(Check):
    """Joint angles stamped too late: every other sensor seems to precede the model that they drive.

    Judged on the recording whose joints move most. A drive that follows its command late is none: there the sensors
    agree with the joints. That one stream alone is late is a cause (clock_offset).
    """

    kind = "clock"
    turn = Turn.CLOCKS

    def look(self, evidence: Evidence) -> Iterator[Found]:
        moved = {
            k: float(np.ptp(evidence.recordings[k][DRIVE].values, axis=0).max())
            for k in evidence.indices
            if DRIVE in evidence.recordings[k]
        }
        most = max(moved, key=moved.__getitem__, default=None)
        if most is None or moved[most] < SWING:
            return
        behind = {k: _behind(evidence, k) for k in moved}
        lags = {stream: lag for stream in STREAMS if (lag := _lag(evidence, most, stream)) is not None}
        if len(lags) < len(STREAMS):
            return
        told, late, names = behind[most], 0.0, [DRIVE]
        if told is not None and abs(told) > BEHIND:
            late = told if all(abs(lag + told) < abs(lag) for lag in lags.values()) else 0.0
        elif min(map(abs, lags.values())) > ALONE and np.ptp(list(lags.values())) < ALONE / 2:
            late = -float(np.mean(list(lags.values())))
            names += [] if told is None else [COMMAND, "joint_command/velocity"]
        said = ", ".join(f"{stream.strip('/')} by {-lag:.2f} s" for stream, lag in lags.items())
        for index in moved if late else ():
            own = behind[index]
            if told is not None and abs(told) > BEHIND and own is not None and abs(own - late) > ALIKE * abs(late):
                continue
            text = f"stamps are {late:+.3f} s late: other sensors precede the model that the joints drive, {said}"
            finding = evidence.finding(self.kind, index, DRIVE, text, Action.REPAIRED, True)
            there = [name for name in names if name in evidence.recordings[index]]
            yield Found(index, finding, restamped(there, partial(_earlier, late)))


def _behind(evidence: Evidence, index: int) -> float | None:
    """By how much joint angles are behind their commands, s; None without commands that move."""
    should = expected(evidence, index, DRIVE)
    if should is None or np.ptp(should, axis=0).max() < SWING:
        return None
    joints = evidence.recordings[index][DRIVE]
    speed = np.gradient(should, joints.time, axis=0)
    beyond = joints.values - should
    rest = np.abs(speed).max(axis=1) < 1e-4
    beyond = beyond - (beyond[rest].mean(axis=0) if rest.any() else beyond.mean(axis=0))
    return -float(np.sum(speed * beyond) / np.sum(speed**2))


def _lag(evidence: Evidence, index: int, stream: str) -> float | None:
    """Delay of the model at which a stream fits best, about its means, s; None where it surely fits no better."""
    log, cost, count = evidence.recordings[index], np.zeros(len(LAGS)), 0
    joints = log[DRIVE].time
    for name in evidence.measured(index):
        if not name.startswith(stream) or evidence.predicted(index, name) is None:
            continue
        signal, noise = log[name], evidence.noise(name)
        inside = (signal.time > joints[0] - LAGS[0]) & (signal.time < joints[-1] - LAGS[-1])
        count += int(inside.sum()) * len(noise)
        for k, lag in enumerate(LAGS):
            rest = (signal.values - evidence.predicted(index, name, float(lag)))[inside]
            cost[k] += float(inside.sum() * np.nansum(np.nanvar(rest, axis=0) / noise**2))
    k = int(np.clip(np.argmin(cost), 1, len(LAGS) - 2))
    a, b, c = cost[k - 1 : k + 2]
    bend = a - 2 * b + c
    least = b - (a - c) ** 2 / (8 * bend) if bend > 0 else np.inf
    if cost[len(LAGS) // 2] - least <= SURE**2 * max(1.0, b / max(count, 1)):
        return None
    return float(LAGS[k] + (LAGS[1] - LAGS[0]) * 0.5 * (a - c) / bend)
