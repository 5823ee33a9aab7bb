"""Simulated recordings of an MJCF machine as tables."""

from collections.abc import Mapping, Sequence

import numpy as np

from boom_mj.estimation.dataset import Dataset
from boom_mj.recording import Recording


def tables(data: Dataset, said: Sequence[Mapping[str, np.ndarray]]) -> dict[str, dict[str, np.ndarray]]:
    """What was said of all stretches as one table per log, by its path: time, and channels by name and unit."""
    logs: dict[str, list[tuple[Recording, Mapping[str, np.ndarray]]]] = {}
    for log, one in zip(data.recordings, said):
        logs.setdefault(log.description, []).append((log, one))
    return {
        path: {
            "time [s]": np.concatenate([log[next(iter(one))].time for log, one in parts]),
            **{
                f"{name} [{parts[0][0][name].unit}]": np.concatenate([one[name][:, 0] for _, one in parts])
                for name in parts[0][1]
            },
        }
        for path, parts in logs.items()
    }
