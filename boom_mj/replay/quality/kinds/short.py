"""Recordings too short to teach or to judge."""

from collections.abc import Iterator

from boom_mj.replay.quality.check import Check, Found, Turn
from boom_mj.replay.quality.edits import DRIVE
from boom_mj.replay.quality.evidence import Evidence
from boom_mj.replay.quality.finding import Action

SHORTEST = 4.0  # s: two periods of a 36 m boom's first mode


class Short(Check):
    """A recording in which the boom's first mode does not come round twice; left out where others do its part."""

    kind = "too short"
    turn = Turn.STAMPS

    def look(self, evidence: Evidence) -> Iterator[Found]:
        lasts = {k: _duration(evidence, k) for k in evidence.indices}
        for part in (range(evidence.training), range(evidence.training, len(evidence.recordings))):
            short = [k for k in part if k in lasts and lasts[k] < SHORTEST]
            others = len([k for k in part if k in lasts]) > len(short)
            for index in short:
                what = "teach" if index < evidence.training else "judge by"
                text = f"lasts {lasts[index]:.2f} s, too short to {what}: {SHORTEST:g} s are needed"
                action = Action.LEFT_OUT if others else Action.SAID
                yield Found(index, evidence.finding(self.kind, index, "", text, action, not others), leave_out=others)


def _duration(evidence: Evidence, index: int) -> float:
    log = evidence.recordings[index]
    return float(log[DRIVE].time[-1] - log[DRIVE].time[0]) if DRIVE in log else log.duration
