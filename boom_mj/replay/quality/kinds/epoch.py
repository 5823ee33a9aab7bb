"""Streams without time in common with the joint angles."""

from collections.abc import Iterator

import numpy as np

from boom_mj.replay.quality.check import Check, Found, Turn
from boom_mj.replay.quality.edits import DRIVE, dropped, together
from boom_mj.replay.quality.evidence import Evidence
from boom_mj.replay.quality.finding import Action, DataFinding


class Epoch(Check):
    """Stamps of a sensor that share no moment with those of the joints: they count from another epoch.

    Where no sensor shares one with the joints, it is the joints that are elsewhere.
    """

    kind = "no time in common"
    turn = Turn.STAMPS

    def look(self, evidence: Evidence) -> Iterator[Found]:
        for index in evidence.indices:
            log, sensors = evidence.recordings[index], evidence.sensors(index)
            if DRIVE not in log:
                continue
            span = {sensor: log[names[0]].time[[0, -1]] for sensor, names in sensors.items()}
            joints = span.pop(DRIVE)
            away = [s for s, (first, last) in span.items() if first > joints[1] or last < joints[0]]
            if away and len(away) == len(span):
                text = f"({_said(joints)}) has no time in common with {', '.join(away)} ({_said(span[away[0]])})"
                yield Found(index, self._finding(evidence, index, DRIVE, text))
                continue
            for sensor in away:
                text = f"({_said(span[sensor])}) has no time in common with {DRIVE} ({_said(joints)})"
                finding = self._finding(evidence, index, sensor, text)
                yield Found(index, finding, together([dropped(name) for name in sensors[sensor]]))

    def _finding(self, evidence: Evidence, index: int, sensor: str, text: str) -> DataFinding:
        return evidence.finding(self.kind, index, sensor, text, Action.REFUSED, False)


def _said(span: np.ndarray) -> str:
    return f"{span[0]:.3f} to {span[1]:.3f} s"
