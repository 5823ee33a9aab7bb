"""Simulated recordings of an MJCF machine as tables."""

from collections.abc import Sequence

import numpy as np

from boom_mj.estimation.dataset import Dataset
from boom_mj.recording import Recording


def tables(data: Dataset, said: Sequence[Recording]) -> dict[str, dict[str, np.ndarray]]:
    """What was said of all stretches as one table per log, by its path: time, and channels by name and unit."""
    logs: dict[str, list[Recording]] = {}
    for log, one in zip(data.recordings, said):
        logs.setdefault(log.description, []).append(one)
    return {
        path: {
            "time [s]": np.concatenate([next(iter(one.signals.values())).time for one in parts]),
            **{
                f"{name} [{signal.unit}]": np.concatenate([one[name].values[:, 0] for one in parts])
                for name, signal in parts[0].signals.items()
            },
        }
        for path, parts in logs.items()
    }
