"""What delays and low-pass filters make of a sampled signal, and the way back."""

from collections.abc import Callable
from contextvars import ContextVar
from typing import Any, Self

import numpy as np

Array = np.ndarray


class Running:
    """Filters that go on from one moment to the next: within it they are given the last two moments only.

    They are told apart by the order in which they are called, the same at every moment.
    """

    def __init__(self) -> None:
        self._states: list[Any] = []
        self._asked = 0

    def __enter__(self) -> Self:
        self._token, self._asked = _RUNNING.set(self), 0
        return self

    def __exit__(self, *error: object) -> None:
        _RUNNING.reset(self._token)

    def step(self, first: Any, after: Callable[[Any], Any]) -> tuple[Any, Any]:
        """State of the filter that asks, a moment ago and now.

        Args:
            first: its state at the first moment.
            after: from a state that of the next moment.
        """
        number, self._asked = self._asked, self._asked + 1
        if number == len(self._states):
            self._states.append(first)
        before = self._states[number]
        self._states[number] = after(before)
        return before, self._states[number]


_RUNNING: ContextVar[Running | None] = ContextVar("running", default=None)


def later(time: Array, values: Array, delay: float) -> Array:
    """Values that come later by some seconds (earlier, for a negative delay), (n,)."""
    return np.interp(time - delay, time, values)


def lagged(time: Array, values: Array, constant: float) -> Array:
    """Through a first-order low-pass with some time constant, s, from rest, (..., n); exact for uniform times."""
    if constant <= 0 or len(time) < 2:
        return values
    keep = np.exp(-(time[1] - time[0]) / constant)
    if running := _RUNNING.get():
        states = running.step(values[..., 0], lambda state: keep * state + (1 - keep) * values[..., 1])
        return np.stack(states, axis=-1)
    from scipy.signal import lfilter

    return lfilter([1 - keep], [1, -keep], values, zi=keep * values[..., :1])[0]


def fading(time: Array, direction: Array, constant: float) -> Array:
    """After each stop the direction of the motion that ended, fallen to 1/e after `constant`, s; in motion 0, (..., n).

    Args:
        direction: -1 to 1, (..., n); it moves where it is beyond a half.
    """
    moving = np.abs(direction) > 0.5
    if running := _RUNNING.get():
        first = np.stack([direction[..., 0], np.full(direction.shape[:-1], time[0])])
        now = np.stack([direction[..., 1], np.full(direction.shape[:-1], time[1])])
        states = running.step(first, lambda state: np.where(moving[..., 1], now, state))
        before, stopped = np.stack(states, axis=-1)
    else:
        last = np.maximum.accumulate(np.where(moving, np.arange(len(time)), 0), axis=-1)
        before, stopped = np.take_along_axis(direction, last, axis=-1), time[last]
    since = np.maximum(time - stopped, 0.0)  # recordings one after the other begin anew
    return np.where(moving, 0.0, np.round(before) * np.exp(-since / constant))


def rate(time: Array, values: Array) -> Array:
    """Of change of values, (..., n)."""
    return np.gradient(values, time, axis=-1)


def led(time: Array, values: Array, constant: float) -> Array:
    """What a first-order low-pass has made these values of, (n,)."""
    return values if constant <= 0 else values + constant * np.gradient(values, time)
