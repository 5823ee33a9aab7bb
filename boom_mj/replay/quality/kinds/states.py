"""Recordings of a machine in different states."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

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
    did the machine: a payload, a fault, another boom. Recordings of other states are left out, with the call that
    diagnoses them apart.
    """

    kind = "state"
    turn = Turn.SET

    def look(self, evidence: Evidence) -> Iterator[Found]:
        rests = {index: list(_rests(evidence, index)) for index in evidence.indices}
        apart = {
            frozenset((one, other)): far
            for one, other in combinations(evidence.indices, 2)
            if (far := _apart(rests[one], rests[other])) is not None
        }
        for group in groups_of(evidence.indices, evidence.training, apart)[1:]:
            for index in group:
                far, other = max((apart.get(frozenset((index, k)), 0.0), k) for k in evidence.indices if k != index)
                text = (
                    f"shows another state of the machine than {evidence.names[other]}: in the same pose under the same "
                    f"load {FEWEST} marker coordinates or more are {far:.0f} times their noise elsewhere"
                    if far > APART
                    else f"belongs to another state of the machine, with {_named(group, index, evidence)}"
                )
                text += f"; to be diagnosed apart: {_call(group, evidence)}"
                finding = evidence.finding(self.kind, index, "", text, Action.LEFT_OUT, False)
                yield Found(index, finding, leave_out=True)


def groups_of(indices: Sequence[int], training: int, apart: Mapping[frozenset[int], float]) -> list[tuple[int, ...]]:
    """Which recordings belong together: first those to diagnose - most of them train -, then each other state.

    One that cannot be compared is with the others of its part, training or held out, if those are all of one state.

    Args:
        training: indices below it are for training.
        apart: of pairs of recordings, how far apart the machine stood; none of pairs that cannot be compared.
    """
    compared = {k: [pair for pair in apart if k in pair] for k in indices}
    groups: list[list[int]] = []
    for index in sorted(indices, key=lambda k: (-len(compared[k]), k)):  # those that tell most
        near = [g for g in groups if not _differ([index], g, apart)]
        alike = [g for g in near if any(frozenset((index, k)) in apart for k in g)]
        if alike:
            alike[0].append(index)
        else:
            groups.append([index])
    main = max(groups, key=lambda g: (sum(k < training for k in g), len(g), -min(g)))
    found, others = list(main), [sorted(g) for g in groups if g is not main and _differ(g, main, apart)]
    for index in sorted(set(indices) - set(main) - {k for g in others for k in g}):
        beside = {k for k in indices if compared[k] and (k < training) == (index < training)}
        own = [g for g in others if beside and beside <= {*g}]
        (own[0] if own and not compared[index] else found).append(index)
    return [tuple(sorted(g)) for g in (found, *sorted(others))]


def _differ(one: Sequence[int], other: Sequence[int], apart: Mapping[frozenset[int], float]) -> bool:
    return any(apart.get(frozenset((a, b)), 0.0) > APART for a in one for b in other)


def _apart(one: Sequence[Rest], other: Sequence[Rest]) -> float | None:
    """How far apart the machine stood, in noise, where poses and loads are the same; None where none are."""
    far = [
        float(np.sort(np.nan_to_num(np.abs(a.error - b.error)))[-FEWEST])
        for a in one
        for b in other
        if np.abs(a.pose - b.pose).max() < POSE and np.abs(a.load - b.load).max() < FORCE
    ]
    return max(far, default=None)


def _named(group: Sequence[int], index: int, evidence: Evidence) -> str:
    return ", ".join(evidence.names[k] for k in group if k != index)


def _call(group: Sequence[int], evidence: Evidence) -> str:
    train, held_out = ([evidence.names[k] for k in group if (k < evidence.training) == part] for part in (True, False))
    words = [*train, "--holdout", *held_out] if train and held_out else train or held_out
    return " ".join(["gap diagnose", *words])


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
            error = (markers.values - predicted)[inside] / evidence.noise(MARKERS)
            count = np.isfinite(error).sum(axis=0)
            mean = np.where(count > 3, np.nansum(error, axis=0) / np.maximum(count, 1), np.nan)
            yield Rest(first if row == 0 else last, load[row], mean)
