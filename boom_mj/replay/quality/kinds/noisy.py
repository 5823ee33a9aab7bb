"""Noise unlike the machine file's."""

from collections.abc import Iterator

import numpy as np

from boom_mj.replay.quality.assessment import quiet_noise
from boom_mj.replay.quality.channels import resolution
from boom_mj.replay.quality.check import Check, Found, Turn
from boom_mj.replay.quality.edits import DRIVE
from boom_mj.replay.quality.evidence import Evidence
from boom_mj.replay.quality.finding import Action

NOISE_RANGE = (0.4, 2.0)  # times the machine file's: clean channels show 0.65 to 1.35
FEWEST = 100  # samples, below which the noise is not known to a tenth


class Noisy(Check):
    """A channel that scatters far more, or far less, than the machine file says, in its quieter half.

    More is taken into the noise; less may be a filter or another sensor and is said.
    """

    kind = "noise"
    turn = Turn.SAMPLES

    def look(self, evidence: Evidence) -> Iterator[Found]:
        low, high = NOISE_RANGE
        for index in evidence.indices:
            for name in evidence.measured(index):
                signal, expected = evidence.recordings[index][name], evidence.noise(name)
                for column, values in enumerate(signal.values.T):
                    known = values[np.isfinite(values)]
                    if len(known) < FEWEST or resolution(known) > 2 * expected[column] or np.ptp(known) == 0:
                        continue
                    own = quiet_noise(signal.time, values)
                    ratio = own / expected[column]
                    if low <= ratio <= high:
                        continue
                    raised = expected.copy()
                    raised[column] = max(own, expected[column])
                    text = f"scatters by {own:.3g} {signal.unit}, {ratio:.2g} times what the machine file says"
                    action = Action.NOISE_RAISED if ratio > high and name != DRIVE else Action.SAID
                    channel = f"{name}/{signal.channels[column]}"
                    finding = evidence.finding(self.kind, index, channel, text, action, True)
                    yield Found(index, finding, noise={name: raised} if ratio > high else {})
