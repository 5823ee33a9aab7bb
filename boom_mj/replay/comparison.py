"""Two recordings of one experiment, channel group by channel group, in units of sensor noise."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from boom_mj.recording import Recording

Array = np.ndarray
MARKERS_PER_LINK = 3


@dataclass(frozen=True)
class Group:
    """How far simulation and log are apart in one channel group.

    Attributes:
        name: sensor and direction: imu/link5 accelerometer y, markers link4 z, cylinder3, ...
        rms: of measured - simulated, in `unit`.
        noise: standard deviation of the sensor.
        ratio: rms / noise.
        signal: where its channels lie in a recording.
        columns: which of the signal's they are.
    """

    name: str
    unit: str
    rms: float
    noise: float
    signal: str
    columns: tuple[int, ...]

    @property
    def ratio(self) -> float:
        """rms / noise."""
        return self.rms / self.noise if self.noise else float("inf")


def compare(
    log: Recording, twin: Recording, noise: Mapping[str, Array], group_of: Callable[[str, int], str] | None = None
) -> tuple[Group, ...]:
    """Root mean square of log - simulation in every channel group, against the sensor's noise.

    Args:
        noise: of samples, by signal, one per channel, (k,).
        group_of: name of the group of a signal's column; of a boom's if left out.
    """
    groups = []
    for name, level in noise.items():
        if name not in log or name not in twin or name == "joint/position":
            continue
        signal = log[name]
        difference = signal.values - twin[name].values
        columns_of: dict[str, list[int]] = {}
        for column, channel in enumerate(signal.channels):
            group = group_of(name, column) if group_of else boom_group(name, channel)
            columns_of.setdefault(group, []).append(column)
        for group, columns in columns_of.items():
            part = difference[:, columns]
            rms = float(np.sqrt(np.nanmean(part**2))) if np.isfinite(part).any() else float("nan")
            groups.append(Group(group, signal.unit, rms, float(level[columns[0]]), name, tuple(columns)))
    return tuple(groups)


def residual(log: Recording, twin: Recording) -> Recording:
    """Measured - simulated, of all signals that both have but what drives the model."""
    signals = {
        name: replace(signal, values=signal.values - twin[name].values)
        for name, signal in log.signals.items()
        if name in twin and not name.startswith("joint") and name != "load"
    }
    return replace(log, description=f"measured - simulated: {log.description}", signals=signals)


def boom_group(name: str, channel: str) -> str:
    """Channel group of a channel: sensor, link and direction, such as "markers/link4/z"."""
    if name == "markers":
        number, axis = int(channel.partition("/")[0].removeprefix("marker")), channel[-1]
        return f"markers/link{2 + (number - 1) // MARKERS_PER_LINK}/{axis}"
    return channel if name.startswith("cylinder") else f"{name}/{channel}"
