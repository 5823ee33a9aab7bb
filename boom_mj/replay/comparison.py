"""Two recordings of one experiment, channel group by channel group, in units of sensor noise."""

from dataclasses import dataclass, replace

import numpy as np

from boom_mj.recording import Recording

Array = np.ndarray


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


def compare(log: Recording, twin: Recording, noise: dict[str, Array]) -> tuple[Group, ...]:
    """Root mean square of log - simulation in every channel group, against the sensor's noise."""
    groups = []
    for name, level in noise.items():
        if name not in log or name not in twin or name == "joint/position":
            continue
        signal = log[name]
        difference = signal.values - twin[name].values
        for group, columns in _groups(name, signal.channels).items():
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


def _groups(name: str, channels: tuple[str, ...]) -> dict[str, list[int]]:
    """Channel groups of a signal: name to columns."""
    if name == "markers":
        found: dict[str, list[int]] = {}
        for column, channel in enumerate(channels):
            number, axis = int(channel[len("marker") : channel.index("/")]), channel[-1]
            found.setdefault(f"markers/link{2 + (number - 1) // 3}/{axis}", []).append(column)
        return found
    stem = "cylinder" if name.startswith("cylinder") else name
    return {(channel if stem == "cylinder" else f"{name}/{channel}"): [k] for k, channel in enumerate(channels)}
