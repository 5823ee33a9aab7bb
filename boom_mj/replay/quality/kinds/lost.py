"""Messages that are not there."""

from collections.abc import Iterator

import numpy as np

from boom_mj.replay.quality.check import Check, Found, Turn
from boom_mj.replay.quality.edits import DRIVE
from boom_mj.replay.quality.evidence import Evidence
from boom_mj.replay.quality.finding import Action

HOLE, LOST = 5.0, 0.01  # usual steps of one stretch, share of messages: clean logs have no hole and lose none
LATE = 1.0  # s without a sensor at the ends of the joints' time: recorders start and stop within less


class Lost(Check):
    """Steps of the stamps that are longer than usual, and samples that are NaN: the model is compared with the rest."""

    kind = "dropped"
    turn = Turn.SAMPLES

    def look(self, evidence: Evidence) -> Iterator[Found]:
        for index in evidence.indices:
            measured = set(evidence.measured(index))
            for sensor, names in evidence.sensors(index).items():
                if measured & set(names):
                    for text, span in (*_steps(evidence, index, names[0]), *_ends(evidence, index, names[0])):
                        action = Action.SAID if sensor == DRIVE else Action.LEFT_OUT
                        yield Found(index, evidence.finding(self.kind, index, sensor, text, action, True, span))


def _steps(evidence: Evidence, index: int, name: str) -> Iterator[tuple[str, tuple[float, float]]]:
    time = evidence.recordings[index][name].time
    step = np.diff(time)
    if len(step) < 10:
        return
    usual = float(np.median(step))
    missing = np.maximum(np.round(step / usual) - 1, 0)
    holes = np.flatnonzero(step > HOLE * usual)
    for hole in holes:
        yield f"has a hole of {step[hole]:.2f} s", (float(time[hole]), float(time[hole + 1]))
    single = float(np.delete(missing, holes).sum())
    if single / (len(time) + single) > LOST:
        share = single / (len(time) + single)
        yield f"lost {100 * share:.1f} % of its messages, one by one", (float(time[0]), float(time[-1]))


def _ends(evidence: Evidence, index: int, name: str) -> Iterator[tuple[str, tuple[float, float]]]:
    log = evidence.recordings[index]
    if DRIVE not in log:
        return
    (first, last), (begin, end) = log[DRIVE].time[[0, -1]], log[name].time[[0, -1]]
    if begin - first > LATE:
        yield f"begins {begin - first:.2f} s after the joint angles", (float(first), float(begin))
    if last - end > LATE:
        yield f"ends {last - end:.2f} s before the joint angles", (float(end), float(last))
