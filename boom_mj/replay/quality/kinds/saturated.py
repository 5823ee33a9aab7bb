"""Samples at the end of a sensor's range."""

from collections.abc import Iterator

import numpy as np

from boom_mj.replay.quality.channels import limits, own_noise
from boom_mj.replay.quality.check import Check, Found, Turn
from boom_mj.replay.quality.edits import DRIVE, blanked
from boom_mj.replay.quality.evidence import Evidence
from boom_mj.replay.quality.finding import Action

Array = np.ndarray
BESIDE = 0.1  # s around samples at the limit: what noise has kept off it there is biased


class Saturated(Check):
    """Samples that pile up on the least or largest value (see `limits`): what lay beyond was cut off."""

    kind = "saturated"
    turn = Turn.DEAD

    def look(self, evidence: Evidence) -> Iterator[Found]:
        for index in evidence.indices:
            for name in evidence.measured(index):
                if name == DRIVE:
                    continue
                signal, noise = evidence.recordings[index][name], evidence.noise(name)
                for column, values in enumerate(signal.values.T):
                    level = min(filter(None, (noise[column], own_noise(values))), default=0.0)
                    for end in limits(values, level) if level else ():
                        at = np.flatnonzero(values == end)
                        bad = np.zeros(signal.values.shape, bool)
                        bad[:, column] = np.abs(signal.time[:, None] - signal.time[at]).min(axis=1) <= BESIDE
                        text = f"stops at {end:.6g} {signal.unit} in {len(at)} of {len(values)} samples"
                        finding = evidence.finding(
                            self.kind,
                            index,
                            f"{name}/{signal.channels[column]}" if len(signal.channels) > 1 else name,
                            text,
                            Action.CENSORED,
                            True,
                            (float(signal.time[at[0]]), float(signal.time[at[-1]])),
                        )
                        yield Found(index, finding, blanked(name, bad))
