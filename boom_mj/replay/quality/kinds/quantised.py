"""Coarse converters."""

from collections.abc import Iterator

import numpy as np

from boom_mj.replay.quality.channels import resolution
from boom_mj.replay.quality.check import Check, Found, Turn
from boom_mj.replay.quality.evidence import Evidence
from boom_mj.replay.quality.finding import Action

COARSE = 2.0  # times the noise: such steps add a seventh to it; clean logs have a tenth
FEW = 40  # levels over the range of a channel whose noise is not known


class Quantised(Check):
    """Readings in steps q that are wider than the noise s: their error is as large as sqrt(s^2 + q^2 / 12)."""

    kind = "quantised"
    turn = Turn.SAMPLES
    of_any_machine = True

    def look(self, evidence: Evidence) -> Iterator[Found]:
        for index in evidence.indices:
            for name in evidence.measured(index):
                signal = evidence.recordings[index][name]
                level = evidence.noise(index, name)
                steps = np.array([resolution(values) for values in signal.values.T])
                known = name in evidence.levels
                coarse = steps > (COARSE * level if known else _ranges(signal.values) / FEW)
                for column in np.flatnonzero(coarse):
                    text = f"comes in steps of {steps[column]:.4g} {signal.unit}"
                    if known:
                        text += f", {steps[column] / level[column]:.1f} times its noise"
                    raised = level.copy()
                    raised[column] = np.hypot(level[column], steps[column] / np.sqrt(12))
                    channel = f"{name}/{signal.channels[column]}" if len(signal.channels) > 1 else name
                    finding = evidence.finding(self.kind, index, channel, text, Action.NOISE_RAISED, True)
                    yield Found(index, finding, noise={name: raised})


def _ranges(values: np.ndarray) -> np.ndarray:
    """(k,); infinite for a channel that does not move."""
    known = np.isfinite(values).any(axis=0)
    span = np.full(values.shape[1], np.inf)
    span[known] = np.nanmax(values[:, known], axis=0) - np.nanmin(values[:, known], axis=0)
    return np.where(span > 0, span, np.inf)
