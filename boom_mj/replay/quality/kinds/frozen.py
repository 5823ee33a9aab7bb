"""Joint angles that stand still while their commands do not."""

from collections.abc import Iterator

import numpy as np
from scipy.ndimage import maximum_filter1d, minimum_filter1d

from boom_mj.replay.quality.beside import expected
from boom_mj.replay.quality.check import Check, Found, Turn
from boom_mj.replay.quality.edits import DRIVE, blanked
from boom_mj.replay.quality.evidence import Evidence, spans
from boom_mj.replay.quality.finding import Action

WINDOW = 1.0  # s
MOVES = 25.0  # times the sensor's noise that the command moves within a window: half a degree
FOLLOWS = 0.25  # of that, which a joint moves at least; sound ones move as much as their commands


class Frozen(Check):
    """Within WINDOW a joint's command moves by MOVES and the joint by less than FOLLOWS of that, noise included.

    The stretch is bridged along the command. Joints that follow late, all of them as much, stand still only if they do
    beside the command of then, too.
    """

    kind = "frozen"
    turn = Turn.JOINT_COURSE

    def look(self, evidence: Evidence) -> Iterator[Found]:
        for index in evidence.indices:
            should = expected(evidence, index, DRIVE)
            if should is None:
                continue
            joints, noise = evidence.recordings[index][DRIVE], evidence.noise(DRIVE)
            size = max(3, round(WINDOW / float(np.median(np.diff(joints.time)))))
            before = _delayed(should, _lag(joints.values / noise, should / noise, size))
            for column, channel in enumerate(joints.channels):
                moved, *commanded = (_range(x[:, column], size) for x in (joints.values, should, before))
                least = np.minimum(*commanded)
                still = (least > MOVES * noise[column]) & (moved < FOLLOWS * least)
                for start, stop in spans(still):
                    start, stop = max(0, start - size // 2), min(len(still), stop + size // 2)
                    bad = np.zeros(joints.values.shape, bool)
                    bad[start:stop, column] = True
                    way = np.degrees(np.ptp(should[start:stop, column]))
                    text = f"stands still while its command moves by {way:.2f} deg"
                    span = float(joints.time[start]), float(joints.time[stop - 1])
                    finding = evidence.finding(
                        self.kind, index, f"{DRIVE}/{channel}", text, Action.REPAIRED, True, span
                    )
                    yield Found(index, finding, blanked(DRIVE, bad))


def _delayed(values: np.ndarray, rows: int) -> np.ndarray:
    """What they were some rows before, (n, k)."""
    return values[np.maximum(np.arange(len(values)) - rows, 0)]


def _lag(values: np.ndarray, commands: np.ndarray, most: int) -> int:
    """By how many rows commands are delayed where they are most like values, (n, k) both."""
    return int(np.argmin([np.nansum((values - _delayed(commands, rows)) ** 2) for rows in range(most + 1)]))


def _range(values: np.ndarray, size: int) -> np.ndarray:
    return maximum_filter1d(values, size) - minimum_filter1d(values, size)
