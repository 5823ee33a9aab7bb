"""Joint angle sensors zeroed anew, or far off."""

from collections.abc import Iterator, Mapping, Sequence

import numpy as np
from scipy.ndimage import maximum_filter1d, minimum_filter1d

from boom_mj.replay.quality.beside import expected
from boom_mj.replay.quality.check import Check, Found, Turn
from boom_mj.replay.quality.edits import DRIVE, mapped
from boom_mj.replay.quality.evidence import Evidence
from boom_mj.replay.quality.finding import Action, Repair

Array = np.ndarray
ANEW = 5.0  # times a joint sensor's noise: sound logs of one machine differ by a hundredth of it at the same angle
POSE = np.radians(1.0)  # within which two angles are the same: a nonlinear sensor's error changes by 2 % of itself
BEYOND = np.radians(1.8)  # rad, three deviations of what a diagnosis takes for a zero offset
STILL, REST = np.radians(0.01), 1.0  # rad by which the command moves at most within as many s of a rest


class ZeroOffset(Check):
    """Reading less command at rest: where it differs between recordings at the same angle, a sensor was zeroed anew.

    The reading is brought back to that of the first training recording, or to its command where it is off by more than
    any zero offset. So is that of a recording that cannot be compared, if all others of its part, training or held out,
    were shifted alike and it is nearer to them than to the rest. An error that is a function of the angle - a nonlinear
    sensor - is a cause and no finding, and so is a zero offset of ordinary size that all recordings share.
    """

    kind = "zero offset"
    turn = Turn.JOINT_COURSE

    def look(self, evidence: Evidence) -> Iterator[Found]:
        rests = {k: _rests(evidence, k) for k in evidence.indices}
        noise = np.radians(evidence.machine.sensors.noise.joint_deg)
        for column in range(5):
            known: list[tuple[float, float]] = []  # angle, error of rests that are believed
            shifts: dict[int, float] = {}  # of recordings that share an angle with another
            errors = {k: float(np.median([e[column] for _, e in found] or [0.0])) for k, found in rests.items()}
            for index in evidence.indices:
                own = [(angle[column], error[column]) for angle, error in rests[index]]
                apart = [e - k for a, e in own for b, k in known if abs(a - b) < POSE]
                shift = float(np.median(apart)) if apart else 0.0
                error = errors[index]
                if apart or any(abs(a - b[column]) < POSE for a, _ in own for b in _angles(rests, index)):
                    shifts[index] = shift
                if abs(shift) > ANEW * noise:
                    text = f"reads {np.degrees(shift):.3g} deg otherwise than in the logs before, at the same angle"
                elif not apart and abs(error) > BEYOND:
                    text, shift = f"reads {np.degrees(error):.3g} deg more than commanded", error
                else:
                    known += own
                    continue
                known += [(a, e - shift) for a, e in own]
                shifts[index] = shift
                yield self._found(evidence, index, column, text, shift)
            for index in set(evidence.indices) - set(shifts):
                beside = [s for k, s in shifts.items() if (k < evidence.training) == (index < evidence.training)]
                if beside and min(map(abs, beside)) > ANEW * noise > np.ptp(beside):
                    shift, sound = float(np.median(beside)), float(np.median([errors[k] - shifts[k] for k in shifts]))
                    if abs(errors[index] - sound - shift) < abs(errors[index] - sound):
                        text = f"reads {np.degrees(shift):.3g} deg otherwise, as all other logs of its part"
                        yield self._found(evidence, index, column, text, shift)

    def _found(self, evidence: Evidence, index: int, column: int, text: str, shift: float) -> Found:
        joints = evidence.recordings[index][DRIVE]
        channel = joints.channels[column]
        back = np.where(np.arange(len(joints.channels)) == column, -shift, 0.0)
        finding = evidence.finding(
            self.kind,
            index,
            f"{DRIVE}/{channel}",
            text,
            Action.REPAIRED,
            True,
            repair=Repair(DRIVE, channel, offset=-shift),
        )
        return Found(index, finding, mapped(DRIVE, np.ones_like(back), back))


def _angles(rests: Mapping[int, Sequence[tuple[Array, Array]]], index: int) -> list[Array]:
    """Commanded angles of the rests of all other recordings."""
    return [angle for other, found in rests.items() if other != index for angle, _ in found]


def _rests(evidence: Evidence, index: int) -> list[tuple[Array, Array]]:
    """Commanded angles of every rest and what the joints read beyond them, (5,) both."""
    should = expected(evidence, index, DRIVE)
    if should is None:
        return []
    joints = evidence.recordings[index][DRIVE]
    size = max(3, round(REST / float(np.median(np.diff(joints.time)))))
    still = (maximum_filter1d(should, size, axis=0) - minimum_filter1d(should, size, axis=0)).max(axis=1) < STILL
    edges = np.flatnonzero(np.diff(np.concatenate([[False], still, [False]]).astype(np.int8))).reshape(-1, 2)
    long = [(a, b) for a, b in edges if b - a >= size]
    return [(should[a:b].mean(axis=0), (joints.values - should)[a:b].mean(axis=0)) for a, b in long]
