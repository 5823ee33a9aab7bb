"""Plugs, points or axes that have taken each other's places."""

from collections.abc import Iterator, Mapping, Sequence

import numpy as np
from scipy.optimize import linear_sum_assignment

from boom_mj.recording import QUANTITIES
from boom_mj.recording.names import AXES, FLEXIBLE_LINKS
from boom_mj.replay.quality.beside import CLEAR, Pair, concerned, having, pairs
from boom_mj.replay.quality.check import Check, Found, Turn
from boom_mj.replay.quality.edits import DRIVE, Edit, mapped, rearranged, reordered, together
from boom_mj.replay.quality.evidence import Evidence
from boom_mj.replay.quality.finding import Action, Repair

Array = np.ndarray
Cycle = tuple[tuple[int, int], ...]  # (place, what fits there)
KINDS = ("specific_force", "angular_rate")


class JointsSwapped(Check):
    """Joint angles that follow each other's commands."""

    kind = "swapped"
    turn = Turn.JOINT_PLACES

    def look(self, evidence: Evidence) -> Iterator[Found]:
        yield from _columns(evidence, DRIVE)


class Swapped(Check):
    """Sensors whose measurements fit each other's predictions: of all permutations that with the least misfit.

    The misfit of measurement j at place i is E_ij = mean |m_j - p_i|^2 in noise; every cycle of the best permutation is
    judged by itself, sum E_i,perm(i) against sum E_ii.
    """

    kind = "swapped"
    turn = Turn.PLACES

    def look(self, evidence: Evidence) -> Iterator[Found]:
        yield from _imus(evidence)
        for link in FLEXIBLE_LINKS:
            for kind in KINDS:
                yield from _axes(evidence, f"imu/link{link}/{kind}")
        yield from _columns(evidence, "cylinder/force")
        yield from _markers(evidence)


def _imus(evidence: Evidence) -> Iterator[Found]:
    """Whole IMUs, by both of their signals."""
    both: dict[int, list[Pair]] = {}
    for kind in KINDS:
        for link in FLEXIBLE_LINKS:
            for index, pair in pairs(evidence, f"imu/link{link}/{kind}"):
                both.setdefault(index, []).append(pair)
    misfit: dict[int, Array] = {}
    count = len(FLEXIBLE_LINKS)
    for index, found in both.items():
        if len(found) == 2 * count and len({len(pair.measured) for pair in found}) == 1:
            kinds = (found[:count], found[count:])
            parts = [_misfit([p.measured for p in k], [p.expected for p in k]) for k in kinds]
            misfit[index] = parts[0] + parts[1]
    places = [f"imu/link{link}" for link in FLEXIBLE_LINKS]
    for cycle, indices in _cycles(misfit, tuple(misfit)).items():
        edit = rearranged({f"{places[i]}/{kind}": f"{places[j]}/{kind}" for i, j in cycle for kind in KINDS})
        for index in indices:
            told = _told(misfit.get(index), cycle)
            for number, (i, j) in enumerate(cycle):
                finding = evidence.finding(
                    "swapped", index, places[i], f"does not fit its place; {places[j]} does, {told}",
                    Action.REPAIRED, True, repair=Repair(places[i], source=places[j]),
                )  # fmt: skip
                yield Found(index, finding, edit if number == len(cycle) - 1 else together([]))


def _columns(evidence: Evidence, name: str) -> Iterator[Found]:
    """Single channels of a signal."""
    misfit = {
        index: _misfit(pair.measured.T[:, :, None], pair.expected.T[:, :, None])
        for index, pair in pairs(evidence, name)
    }
    channels = QUANTITIES[name].channels
    for cycle, indices in _cycles(misfit, having(evidence, name)).items():
        order = list(range(len(channels)))
        for i, j in cycle:
            order[i] = j
        for index in indices:
            yield from _said(
                evidence, index, name, [(channels[i], channels[j]) for i, j in cycle],
                _told(misfit.get(index), cycle), reordered(name, order),
            )  # fmt: skip


def _markers(evidence: Evidence) -> Iterator[Found]:
    misfit = {}
    for index, pair in pairs(evidence, "markers"):
        points = [p.reshape(len(p), -1, 3).transpose(1, 0, 2) for p in (pair.measured, pair.expected)]
        misfit[index] = _misfit(points[0], points[1])
    for cycle, indices in _cycles(misfit, having(evidence, "markers")).items():
        count = len(QUANTITIES["markers"].channels)
        order = list(range(count))
        for i, j in cycle:
            order[3 * i : 3 * i + 3] = range(3 * j, 3 * j + 3)
        places = [(f"marker{i + 1}", f"marker{j + 1}") for i, j in cycle]
        for index in indices:
            yield from _said(
                evidence, index, "markers", places, _told(misfit.get(index), cycle), reordered("markers", order)
            )


def _axes(evidence: Evidence, name: str) -> Iterator[Found]:
    """Axes of an IMU, with whatever signs: one that is only turned is no swap."""
    misfit, signs = {}, {}
    for index, pair in pairs(evidence, name):
        cross = np.nanmean(pair.measured[:, None, :] * pair.expected[:, :, None], axis=0)  # (place, measured)
        square = np.nanmean(pair.measured**2, axis=0)[None] + pair.power[:, None]
        turned = square - 2 * np.abs(cross)
        misfit[index], signs[index] = np.maximum(turned, 1e-9), np.sign(cross)
    for cycle, indices in _cycles(misfit, having(evidence, name)).items():
        told = max(misfit, key=lambda k: _ratio(misfit[k], cycle))
        order, sign = list(range(3)), np.ones(3)
        for i, j in cycle:
            order[i], sign[i] = j, signs[told][i, j]
        for index in indices:
            edit = together([reordered(name, order), mapped(name, sign, np.zeros(3))])
            yield from _said(
                evidence, index, name, [(AXES[i], AXES[j]) for i, j in cycle], _told(misfit.get(index), cycle), edit,
                {AXES[i]: int(sign[i]) for i, _ in cycle},
            )  # fmt: skip


def _said(
    evidence: Evidence,
    index: int,
    name: str,
    places: list[tuple[str, str]],
    told: str,
    edit: Edit,
    signs: Mapping[str, int] | None = None,
) -> Iterator[Found]:
    for number, (place, source) in enumerate(places):
        sign = (signs or {}).get(place, 1)
        text = f"does not fit its place; {'-' if sign < 0 else ''}{source} does, {told}"
        finding = evidence.finding(
            "swapped", index, f"{name}/{place}", text, Action.REPAIRED, True,
            repair=Repair(name, place, sign=sign, source=source),
        )  # fmt: skip
        yield Found(index, finding, edit if number == len(places) - 1 else together([]))


def _misfit(measured: Sequence[Array] | Array, expected: Sequence[Array] | Array) -> Array:
    """E (k, k) of k sensors' samples, (k, n, axes) both: expected down, measured across."""
    return np.array([[np.nanmean((m - p) ** 2) for m in measured] for p in expected])


def _ratio(misfit: Array, cycle: Cycle) -> float:
    return float(sum(misfit[i, i] for i, _ in cycle) / sum(misfit[i, j] for i, j in cycle))


def _told(misfit: Array | None, cycle: Cycle) -> str:
    ratio = 1.0 if misfit is None else _ratio(misfit, cycle)
    return f"{ratio:.3g} times better" if ratio > CLEAR else "as in other logs"


def _cycles(misfit: Mapping[int, Array], indices: tuple[int, ...]) -> dict[Cycle, tuple[int, ...]]:
    """Cycles that some recording shows clearly, and the recordings that have them."""
    shown: dict[Cycle, None] = {}
    for matrix in misfit.values():
        _, best = linear_sum_assignment(np.nan_to_num(matrix, nan=1e12))
        shown |= {c: None for c in _split(best) if _ratio(matrix, c) > CLEAR}
    found, taken = {}, set()
    for cycle in shown:
        ratios = {k: _ratio(matrix, cycle) for k, matrix in misfit.items()}
        indices_of = tuple(k for k in concerned(ratios, indices) if (k, cycle[0][0]) not in taken)
        taken |= {(k, i) for k in indices_of for i, _ in cycle}
        if indices_of:
            found[cycle] = indices_of
    return found


def _split(permutation: Array) -> list[Cycle]:
    """Cycles of a permutation that are longer than one."""
    found, seen = [], set()
    for first in range(len(permutation)):
        cycle, at = [], first
        while at not in seen:
            seen.add(at)
            cycle.append((at, int(permutation[at])))
            at = int(permutation[at])
        if len(cycle) > 1:
            found.append(tuple(cycle))
    return found
