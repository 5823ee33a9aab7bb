"""What delays and low-pass filters make of a sampled signal, and the way back."""

import numpy as np

Array = np.ndarray


def later(time: Array, values: Array, delay: float) -> Array:
    """Values that come later by some seconds (earlier, for a negative delay), (n,)."""
    return np.interp(time - delay, time, values)


def lagged(time: Array, values: Array, constant: float) -> Array:
    """Through a first-order low-pass with some time constant, s, from rest, (..., n); exact for uniform times."""
    if constant <= 0 or len(time) < 2:
        return values
    from scipy.signal import lfilter

    keep = np.exp(-(time[1] - time[0]) / constant)
    return lfilter([1 - keep], [1, -keep], values, zi=keep * values[..., :1])[0]


def fading(time: Array, direction: Array, constant: float) -> Array:
    """After each stop the direction of the motion that ended, fallen to 1/e after `constant`, s; in motion 0, (..., n).

    Args:
        direction: -1 to 1, (..., n); it moves where it is beyond a half.
    """
    moving = np.abs(direction) > 0.5
    last = np.maximum.accumulate(np.where(moving, np.arange(len(time)), 0), axis=-1)
    since = np.maximum(time - time[last], 0.0)  # recordings one after the other begin anew
    before = np.take_along_axis(direction, last, axis=-1)
    return np.where(moving, 0.0, np.round(before) * np.exp(-since / constant))


def rate(time: Array, values: Array) -> Array:
    """Of change of values, (..., n)."""
    return np.gradient(values, time, axis=-1)


def led(time: Array, values: Array, constant: float) -> Array:
    """What a first-order low-pass has made these values of, (n,)."""
    return values if constant <= 0 else values + constant * np.gradient(values, time)
