"""Measured channels beside what they should be: joint angles beside their commands, other sensors beside the model."""

from collections.abc import Hashable, Iterator, Mapping
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from boom_mj.replay.quality.edits import COMMAND, DRIVE
from boom_mj.replay.quality.evidence import Evidence

Array = np.ndarray
Case = TypeVar("Case", bound=Hashable)
SHOWN = 25.0  # mean square, in noise, of what should be there: with less a channel tells nothing
CLEAR = 10.0  # times better or worse


def expected(evidence: Evidence, index: int, name: str) -> Array | None:
    """What a signal should be at its own stamps, (n, k); None where nothing tells."""
    log = evidence.recordings[index]
    if name not in log:
        return None
    if name != DRIVE:
        return evidence.predicted(index, name)
    if COMMAND not in log:
        return None
    command = log[COMMAND]
    return np.stack([np.interp(log[name].time, command.time, c) for c in command.values.T], axis=1)


@dataclass(frozen=True)
class Pair:
    """A signal and what it should be, whitened, (n, k) both; `moving` about their means over the recording."""

    measured: Array
    expected: Array

    @property
    def moving(self) -> "Pair":
        return Pair(self.measured - np.nanmean(self.measured, axis=0), self.expected - self.expected.mean(axis=0))

    @property
    def power(self) -> Array:
        """Mean square of what should be, (k,)."""
        return np.mean(self.expected**2, axis=0)

    def misfit(self, sign: int = 1) -> Array:
        """Mean square of the difference, (k,)."""
        return np.nanmean((self.measured - sign * self.expected) ** 2, axis=0)


def pairs(evidence: Evidence, name: str) -> Iterator[tuple[int, Pair]]:
    """A signal of all recordings that tell what it should be."""
    for index in evidence.indices:
        if (should := expected(evidence, index, name)) is not None:
            values, noise = evidence.recordings[index][name].values, evidence.noise(name)
            alive = np.isfinite(values).any(axis=0)  # what is dead tells nothing
            if alive.any():
                yield index, Pair(np.where(alive, values, 0.0) / noise, np.where(alive, should, 0.0) / noise)


def concerned(ratio: Mapping[int, float], indices: tuple[int, ...], clear: float = CLEAR) -> tuple[int, ...]:
    """Recordings with a fault in the wiring: those that show it, and those that tell nothing unless some lack it.

    Args:
        ratio: by recording, how much worse the data fit without the fault than with it.
        indices: of the recordings that have the signal.
    """
    shown = [k for k, r in ratio.items() if r > clear]
    if not shown:
        return ()
    sound = any(r < 1 / clear for r in ratio.values())
    return tuple(k for k in indices if k in shown or (not sound and ratio.get(k, 1.0) >= 1 / clear))


def having(evidence: Evidence, name: str) -> tuple[int, ...]:
    """Recordings that have a signal."""
    return tuple(k for k in evidence.indices if name in evidence.recordings[k])


def by_case(cases: Mapping[int, Mapping[Case, float]]) -> dict[Case, dict[int, float]]:
    """The same numbers, by what they are of first."""
    found: dict[Case, dict[int, float]] = {}
    for index, numbers in cases.items():
        for case, number in numbers.items():
            found.setdefault(case, {})[index] = number
    return found
