"""Sets in which nothing moves."""

from collections.abc import Iterator

import numpy as np

from boom_mj.replay.quality.check import Check, Found, Turn
from boom_mj.replay.quality.evidence import Evidence
from boom_mj.replay.quality.finding import Action

MOVES = 3.0  # times the noise that a channel moves by, over means of a second; noise alone moves those by half of it
MEAN = 1.0  # s


class AtRest(Check):
    """No channel of any training recording moves: they tell weights and springs, and nothing of motion."""

    kind = "at rest"
    turn = Turn.SET

    def look(self, evidence: Evidence) -> Iterator[Found]:
        training = [k for k in evidence.indices if k < evidence.training]
        most = max((_moved(evidence, k) for k in training), default=np.inf)
        if most > MOVES:
            return
        for index in training:
            text = (
                f"shows the boom at rest, as all logs to learn from do (no channel moves by {MOVES:g} times its "
                "noise): it tells loads and springs, and nothing of dampers, clocks and friction"
            )
            yield Found(index, evidence.finding(self.kind, index, "", text, Action.SAID, True))


def _moved(evidence: Evidence, index: int) -> float:
    """The largest range of a channel's means over MEAN, in noise; of all samples where the recording is shorter."""
    most = 0.0
    for name in evidence.measured(index):
        signal, noise = evidence.recordings[index][name], evidence.noise(name)
        count = max(1, round(MEAN / float(np.median(np.diff(signal.time))))) if len(signal.time) > 1 else 1
        whole = signal.values[: len(signal.values) // count * count]
        if not len(whole):
            continue
        spread = np.nanstd(whole.reshape(-1, count, whole.shape[1]), axis=1) / noise  # swings inside a second
        means = whole.reshape(-1, count, whole.shape[1]).mean(axis=1) / noise
        drift = np.nanmax(means, axis=0) - np.nanmin(means, axis=0) if len(means) > 1 else np.zeros(1)
        most = max(most, float(np.nanmax(drift)), float(np.nanmax(spread)))
    return most
