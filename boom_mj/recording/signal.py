"""One signal: samples over time with unit and frame; resampling, windows, common times, spectra."""

from dataclasses import dataclass, replace

import numpy as np

from boom_mj.errors import LogError

Array = np.ndarray

CLOCK_RESOLUTION = 1e-9  # s, of the stamps in a log
UNIFORM = 0.01  # largest deviation of a sampling step from the usual one that still counts as uniform


@dataclass(frozen=True, eq=False)
class Signal:
    """Samples of k channels at n times.

    Attributes:
        time: (n,), s, strictly increasing.
        values: (n, k) in `unit`; NaN where a channel has no sample (a hidden marker).
        channels: k names.
        unit: SI unit of all channels, such as "rad" or "m/s^2".
        frame: frame in which the values are components, such as "world" or "link2_tip".

    Raises:
        LogError: shapes that do not fit, a time that does not increase, a value that is infinite.
    """

    time: Array
    values: Array
    channels: tuple[str, ...]
    unit: str
    frame: str

    def __post_init__(self) -> None:
        time, values = (_read_only(array) for array in (self.time, self.values))
        channels = tuple(self.channels)
        if time.ndim != 1 or time.size == 0 or not channels or values.shape != (time.size, len(channels)):
            raise LogError(
                f"a signal needs times (n,) with n > 0 and values (n, {len(channels)}) for its channels "
                f"{', '.join(channels)}; got {time.shape} and {values.shape}"
            )
        if len(set(channels)) != len(channels):
            raise LogError(f"channels of a signal need different names; got {', '.join(channels)}")
        if not np.isfinite(time).all():
            raise LogError(f"times of a signal must be finite; sample {np.argmin(np.isfinite(time))} is not")
        if (back := np.flatnonzero(np.diff(time) <= 0)).size:
            i = back[0]
            raise LogError(f"times must increase, but {time[i]:.9f} s is followed by {time[i + 1]:.9f} s")
        if (infinite := np.argwhere(np.isinf(values))).size:
            i, j = infinite[0]
            raise LogError(f"{channels[j]} is infinite at {time[i]:.3f} s; values are finite, or NaN where hidden")
        for name, value in (("time", time), ("values", values), ("channels", channels)):
            object.__setattr__(self, name, value)

    @property
    def rate_hz(self) -> float:
        """Mean sampling rate, Hz; refuses a single sample."""
        if self.time.size < 2:
            raise LogError(f"one sample of {', '.join(self.channels)} has no rate; at least 2 are needed")
        return float((self.time.size - 1) / (self.time[-1] - self.time[0]))


@dataclass(frozen=True, eq=False)
class Spectrum:
    """One-sided amplitude spectrum: a sine of amplitude a in the middle of a bin stands there as a.

    Attributes:
        frequency_hz: (m,), from 0 to half the sampling rate.
        amplitude: (m, k), in the signal's unit; the mean is removed.
    """

    frequency_hz: Array
    amplitude: Array


def resample(signal: Signal, time: Array) -> Signal:
    """Signal at other times, by linear interpolation; next to a NaN it is NaN.

    Args:
        time: (m,), s, strictly increasing, inside the signal's own interval.

    Raises:
        LogError: a time outside the interval (there is no extrapolation).
    """
    time = np.asarray(time, float)
    start, stop = signal.time[[0, -1]]
    if time.size and (time.min() < start - CLOCK_RESOLUTION or time.max() > stop + CLOCK_RESOLUTION):
        raise LogError(
            f"{_names(signal)} cannot be resampled from {time.min():.3f} to {time.max():.3f} s: "
            f"it runs from {start:.3f} to {stop:.3f} s and is never extrapolated"
        )
    values = np.stack([np.interp(time, signal.time, column) for column in signal.values.T], axis=1)  # (m, k)
    return replace(signal, time=time, values=values)


def window(signal: Signal, start: float, stop: float) -> Signal:
    """Samples with start <= time <= stop, s; refuses a window without samples."""
    inside = (signal.time >= start) & (signal.time <= stop)
    if not inside.any():
        raise LogError(
            f"{_names(signal)} has no sample from {start:.3f} to {stop:.3f} s; "
            f"it runs from {signal.time[0]:.3f} to {signal.time[-1]:.3f} s"
        )
    return replace(signal, time=signal.time[inside], values=signal.values[inside])


def align(a: Signal, b: Signal) -> tuple[Signal, Signal]:
    """Both signals at the times of the coarser one, over the interval that they share."""
    start, stop = max(a.time[0], b.time[0]), min(a.time[-1], b.time[-1])
    if start > stop:
        raise LogError(
            f"{_names(a)} ({a.time[0]:.3f} to {a.time[-1]:.3f} s) and {_names(b)} "
            f"({b.time[0]:.3f} to {b.time[-1]:.3f} s) share no time"
        )
    coarser = a if a.rate_hz <= b.rate_hz else b
    time = window(coarser, start, stop).time
    return resample(a, time), resample(b, time)


def spectrum(signal: Signal, taper: str = "hann") -> Spectrum:
    """Amplitude spectrum of a uniformly sampled signal.

    Args:
        taper: window of scipy.signal against leakage; "boxcar" for none.

    Raises:
        LogError: sampling that is not uniform, or a NaN.
    """
    rate_hz, step = signal.rate_hz, np.diff(signal.time)
    usual = np.median(step)  # the mean would blame every step for one gap
    if (uneven := np.flatnonzero(np.abs(step / usual - 1) > UNIFORM)).size:
        i = uneven[0]
        raise LogError(
            f"{_names(signal)} is not sampled uniformly: a step of {step[i]:.6f} s at {signal.time[i]:.3f} s, "
            f"{usual:.6f} s elsewhere; resample it first"
        )
    if (gaps := np.argwhere(np.isnan(signal.values))).size:
        i, j = gaps[0]
        raise LogError(f"{signal.channels[j]} has no value at {signal.time[i]:.3f} s; a spectrum needs all of them")
    from scipy.signal import periodogram  # as long to import as a minute of boom takes to simulate

    frequency_hz, power = periodogram(signal.values, rate_hz, taper, scaling="spectrum", axis=0)
    one_sided = np.full_like(frequency_hz, 2.0)  # a^2 / 2 is a sine's power
    one_sided[0] = 1.0
    if signal.time.size % 2 == 0:
        one_sided[-1] = 1.0
    return Spectrum(frequency_hz, np.sqrt(one_sided[:, None] * power))


def _read_only(array: Array) -> Array:
    copy = np.array(array, dtype=np.float64)
    copy.setflags(write=False)
    return copy


def _names(signal: Signal) -> str:
    first, last = signal.channels[0], signal.channels[-1]
    return first if first == last else f"{first}..{last}"


def sample(signal: Signal, time: Array) -> Array:
    """Values at the given times, (m, k), linear between samples and held beyond them."""
    return np.stack([np.interp(time, signal.time, column) for column in signal.values.T], axis=1)
