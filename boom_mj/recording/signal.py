"""Signals: values over time with a unit and a frame, and what one does with them whatever they mean."""

from dataclasses import dataclass

import numpy as np
from scipy.signal import periodogram

from boom_mj.errors import LogError

Array = np.ndarray


@dataclass(frozen=True)
class Signal:
    """Measured or simulated values; nothing downstream can tell which.

    Attributes:
        time: (n,), s, increasing.
        values: (n, k); NaN where a channel has no value.
        channels: names of the k columns.
        unit: of every channel.
        frame: that the values are expressed in.
    """

    time: Array
    values: Array
    channels: tuple[str, ...]
    unit: str
    frame: str

    def __post_init__(self) -> None:
        for name in ("time", "values"):
            array = np.array(getattr(self, name), dtype=float)
            array.setflags(write=False)
            object.__setattr__(self, name, array)
        if self.values.shape != (len(self.time), len(self.channels)):
            raise ValueError(f"values {self.values.shape} for {len(self.time)} times and channels {self.channels}")

    @property
    def rate_hz(self) -> float:
        """Median sample rate, Hz."""
        return float(1 / np.median(np.diff(self.time))) if len(self.time) > 1 else float("nan")

    def window(self, start: float, stop: float) -> "Signal":
        """The samples with start <= time <= stop (s)."""
        keep = (self.time >= start) & (self.time <= stop)
        return Signal(self.time[keep], self.values[keep], self.channels, self.unit, self.frame)


def resample(signal: Signal, time: Array) -> Signal:
    """Linear interpolation at new times, (m,), s; NaN stays NaN.

    Raises:
        LogError: a time lies outside the signal.
    """
    outside = (time < signal.time[0] - 1e-9) | (time > signal.time[-1] + 1e-9)
    if np.any(outside):
        raise LogError(
            f"time {time[outside][0]:.3f} s lies outside the signal ({', '.join(signal.channels[:3])}, ..), which runs "
            f"from {signal.time[0]:.3f} to {signal.time[-1]:.3f} s"
        )
    values = np.stack([np.interp(time, signal.time, column) for column in signal.values.T], axis=1)
    return Signal(time, values, signal.channels, signal.unit, signal.frame)


def align(first: Signal, second: Signal) -> tuple[Signal, Signal]:
    """Both signals at the times of the slower one, over the time that they share."""
    slow = first if first.rate_hz <= second.rate_hz else second
    start, stop = max(first.time[0], second.time[0]), min(first.time[-1], second.time[-1])
    time = slow.window(start, stop).time
    return resample(first, time), resample(second, time)


def spectrum(signal: Signal) -> tuple[Array, Array]:
    """One-sided power spectral density: frequencies (m,) in Hz and densities (m, k) in unit^2/Hz.

    Raises:
        LogError: the samples are not evenly spaced.
    """
    steps = np.diff(signal.time)
    if steps.size == 0 or np.ptp(steps) > 1e-3 * steps.mean():
        raise LogError("a spectrum needs evenly spaced samples; resample the signal first")
    return periodogram(signal.values, 1 / steps.mean(), detrend="constant", axis=0)
