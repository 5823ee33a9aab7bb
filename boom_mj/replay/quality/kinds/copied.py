"""Recordings that are there twice."""

from collections.abc import Iterator
from itertools import combinations

import numpy as np

from boom_mj.replay.quality.check import Check, Found, Turn
from boom_mj.replay.quality.evidence import Evidence
from boom_mj.replay.quality.finding import Action

Array = np.ndarray
ROWS = 4  # samples in a row: noise repeats one value by chance, not twelve
SHARE = 0.02  # of the rows; independent noise shares none


class Copied(Check):
    """Noise is never the same twice: recordings that share stretches of samples are one recording.

    Held out and training at once, it proves nothing and is refused; twice in one part, it counts once.
    """

    kind = "copy"
    turn = Turn.STAMPS

    def look(self, evidence: Evidence) -> Iterator[Found]:
        rows = {k: _fingerprints(evidence, k) for k in evidence.indices}
        for first, second in combinations(evidence.indices, 2):
            common = [name for name in rows[first] if name in rows[second]]
            shares = [_shared(rows[first][name], rows[second][name]) for name in common]
            share = (
                float(np.median(shares)) if shares else 0.0
            )  # simulated noise of one seed is alike where all is still
            if share < SHARE:
                continue
            one = evidence.names[first]
            across = first < evidence.training <= second
            action = Action.REFUSED if across else Action.LEFT_OUT
            text = (
                f"is held out and shares {share:.0%} of its samples with {one}, which trains"
                if across
                else f"shares {share:.0%} of its samples with {one}"
            )
            finding = evidence.finding(self.kind, second, "", text, action, False)
            yield Found(second, finding, leave_out=not across)


def _fingerprints(evidence: Evidence, index: int) -> dict[str, Array]:
    """Hashes of every ROWS samples in a row, by signal."""
    found = {}
    for name in evidence.measured(index):
        values = np.nan_to_num(evidence.recordings[index][name].values)
        still = (np.diff(values, axis=0) == 0).all(axis=1)
        if len(values) <= ROWS:
            continue
        weight = np.random.default_rng(0).standard_normal(values.shape[1])
        row = values @ weight
        stretch = row[: 1 - ROWS]
        for lag in range(1, ROWS):
            stretch = stretch + (1 + lag * np.sqrt(2)) * row[lag : len(row) - ROWS + 1 + lag]
        moved = ~np.array([still[k : len(still) - ROWS + 2 + k] for k in range(ROWS - 1)]).all(axis=0)
        found[name] = np.unique(stretch[moved])
    return found


def _shared(one: Array, other: Array) -> float:
    fewer = min(len(one), len(other))
    return len(np.intersect1d(one, other, assume_unique=True)) / fewer if fewer > 20 else 0.0
