"""Coarse converters."""

from collections.abc import Iterator

import numpy as np

from boom_mj.replay.quality.channels import resolution
from boom_mj.replay.quality.check import Check, Found, Turn
from boom_mj.replay.quality.evidence import Evidence
from boom_mj.replay.quality.finding import Action

COARSE = 2.0  # times the noise: such steps add a seventh to it; clean logs have a tenth


class Quantised(Check):
    """Readings in steps q that are wider than the noise s: their error is as large as sqrt(s^2 + q^2 / 12)."""

    kind = "quantised"
    turn = Turn.SAMPLES

    def look(self, evidence: Evidence) -> Iterator[Found]:
        for index in evidence.indices:
            for name in evidence.measured(index):
                signal = evidence.recordings[index][name]
                level = evidence.noise(name)
                steps = np.array([resolution(values) for values in signal.values.T])
                for column in np.flatnonzero(steps > COARSE * level):
                    times = f"{steps[column] / level[column]:.1f} times its noise"
                    text = f"comes in steps of {steps[column]:.4g} {signal.unit}, {times}"
                    raised = level.copy()
                    raised[column] = np.hypot(level[column], steps[column] / np.sqrt(12))
                    channel = f"{name}/{signal.channels[column]}" if len(signal.channels) > 1 else name
                    finding = evidence.finding(self.kind, index, channel, text, Action.NOISE_RAISED, True)
                    yield Found(index, finding, noise={name: raised})
