"""Recordings of a machine in different states."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from boom_mj.replay.quality.check import Check, Found, Turn
from boom_mj.replay.quality.edits import DRIVE
from boom_mj.replay.quality.evidence import Evidence
from boom_mj.replay.quality.finding import Action

Array = np.ndarray
MARKERS, LOAD = "markers", "load"
APART = 6.0  # times a marker's noise; one machine, whatever its effects, came back to within 2.5 of it
FEWEST = 3  # channels
POSE, FORCE = np.radians(1.0), 1.0  # rad, N within which pose and load are the same
REST, MOVES = 1.0, np.radians(0.1)  # s at least; rad by which a joint has begun to move
RINGING = 14.0  # s after which a boom of 2 % damping has come to rest
TAIL = 6.0  # s at the end of a recording: some swings of the first mode


@dataclass(frozen=True)
class Rest:
    """A stretch at rest.

    Attributes:
        pose, load: (5,) rad and (3,) N.
        error: measured less predicted of every marker channel, (k,), in noise.
    """

    pose: Array
    load: Array
    error: Array


class States(Check):
    """In one pose under one load a machine stands where it stood, however wrong its model is.

    Measured less predicted marker positions are compared between rests of different recordings; where they differ, so
    did the machine: a payload, a fault, another boom.
    """

    kind = "state"
    turn = Turn.SET

    def look(self, evidence: Evidence) -> Iterator[Found]:
        known: list[tuple[int, Rest]] = []
        for index in evidence.indices:
            rests = list(_rests(evidence, index))
            worst: tuple[float, int] | None = None
            for rest in rests:
                for other, before in known:
                    if np.abs(rest.pose - before.pose).max() < POSE and np.abs(rest.load - before.load).max() < FORCE:
                        apart = np.sort(np.nan_to_num(np.abs(rest.error - before.error)))[-FEWEST]
                        if apart > APART and (worst is None or apart > worst[0]):
                            worst = float(apart), other
            if worst is None:
                known += [(index, rest) for rest in rests]
                continue
            text = (
                f"shows another state of the machine than {evidence.names[worst[1]]}: in the same pose under the same "
                f"load {FEWEST} marker coordinates or more are {worst[0]:.0f} times their noise elsewhere"
            )
            yield Found(index, evidence.finding(self.kind, index, "", text, Action.SAID, True))


def _rests(evidence: Evidence, index: int) -> Iterator[Rest]:
    """The start of a recording, before anything moves, and its end, after long rest."""
    log = evidence.recordings[index]
    predicted = evidence.predicted(index, MARKERS)
    if predicted is None:
        return
    joints, markers = log[DRIVE], log[MARKERS]
    first = joints.values[: max(1, len(joints.time) // 100)].mean(axis=0)
    moved = np.abs(joints.values - first).max(axis=1) > MOVES
    load = np.zeros((len(joints.time), 3))
    if LOAD in log:
        load = np.stack([np.interp(joints.time, log[LOAD].time, c) for c in log[LOAD].values.T], axis=1)
    changed = moved | (np.abs(load - load[0]).max(axis=1) > FORCE)
    start, stop = joints.time[[0, -1]]
    last = joints.values[-max(1, len(joints.time) // 100) :].mean(axis=0)
    late = (np.abs(joints.values - last).max(axis=1) > MOVES) | (np.abs(load - load[-1]).max(axis=1) > FORCE)
    quiet = float(joints.time[np.flatnonzero(late)[-1]]) if late.any() else float(start)
    begin = float(joints.time[np.argmax(changed)]) if changed.any() else float(stop)
    stretches = [(start, begin, 0)] if begin - start > REST else []
    stretches += [(stop - TAIL, stop, -1)] if stop - quiet > RINGING else []
    for since, until, row in stretches:
        inside = (markers.time >= since) & (markers.time <= until)
        if inside.sum() > 3:
            error = (markers.values - predicted)[inside] / evidence.noise(index, MARKERS)
            count = np.isfinite(error).sum(axis=0)
            mean = np.where(count > 3, np.nansum(error, axis=0) / np.maximum(count, 1), np.nan)
            yield Rest(first if row == 0 else last, load[row], mean)
