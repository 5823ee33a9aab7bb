"""Sensors that only one part of a set has."""

from collections.abc import Iterator

from boom_mj.replay.quality.check import Check, Found, Turn
from boom_mj.replay.quality.evidence import Evidence, sensor_of
from boom_mj.replay.quality.finding import Action


class Missing(Check):
    """A sensor that no training recording has and a held-out one does, or the other way round, or only some of a part.

    What is missing in training trains nothing and judges all the same; what is missing held out judges nothing.
    """

    kind = "missing"
    turn = Turn.SET

    def look(self, evidence: Evidence) -> Iterator[Found]:
        has = {k: {sensor_of(name) for name in evidence.measured(k)} for k in evidence.indices}
        for sensor in sorted(set().union(*has.values())):
            without = [k for k in has if sensor not in has[k]]
            for index in without:
                others = [evidence.names[k] for k in has if k not in without]
                part = range(evidence.training) if index < evidence.training else range(evidence.training, len(has))
                whole = " of its part" if all(k in without for k in part if k in has) else ""
                text = f"is missing here and in {len(without) - 1} other logs{whole}; {others[0]} has it"
                yield Found(index, evidence.finding(self.kind, index, sensor, text, Action.SAID, False))
