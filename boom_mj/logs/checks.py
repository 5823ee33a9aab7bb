"""What a signal from a log must be before it is used; joint angles drive the model and must be whole."""

import warnings

import numpy as np

from boom_mj.errors import LogError, LogWarning
from boom_mj.logs.topics import refuse_gaps
from boom_mj.recording import QUANTITIES, Signal

DRIVING = "joint/position"
TURN = 2 * np.pi  # no joint behind the slewing joint turns further; degrees do
SLOW = 20.0  # Hz, about ten samples in a period of the second mode
MODES = (0.5, 1.8)  # Hz, first and second of a boom of the 36 m class, stretched
HOLE, LONGEST_HOLE = 5.0, 1.0  # usual steps that make a step a hole; s that cannot be bridged


def checked(name: str, signal: Signal, where: str) -> Signal | None:
    """The usable part of a signal; None if there is none. Joint angles are taken whole or refused.

    Args:
        where: the topic, for messages.

    Raises:
        LogError: joint angles with holes, or in degrees.
    """
    if QUANTITIES[name].points:
        return signal
    if name == DRIVING:
        refuse_gaps(name, signal)
        _check_angles(signal, where)
        return signal
    bad = np.isnan(signal.values).any(axis=1)
    if bad.all():
        return None
    if bad.any():
        first = signal.time[np.argmax(bad)]
        _warn(f"{where}: {bad.sum()} of {bad.size} samples of '{name}', from {first:.3f} s on, are NaN and left out")
        return Signal(signal.time[~bad], signal.values[~bad], signal.channels, signal.unit, signal.frame)
    return signal


def _check_angles(signal: Signal, where: str) -> None:
    largest = np.abs(signal.values[:, 1:]).max(axis=0)
    if largest.max() > TURN:
        i = int(np.argmax(largest)) + 1
        row = int(np.argmax(np.abs(signal.values[:, i])))
        raise LogError(
            f"{signal.channels[i]} is {signal.values[row, i]:.3g} rad at {signal.time[row]:.3f} s, more than a turn; "
            'if the log is in degrees, say unit = "deg" in a topic map'
        )
    step = np.diff(signal.time)
    if not step.size:
        return
    usual = float(np.median(step))
    holes = np.flatnonzero(step > HOLE * usual)
    if step.max() > LONGEST_HOLE:
        i = int(np.argmax(step))
        raise LogError(
            f"{signal.channels[0]}..{signal.channels[-1]} have a hole of {step[i]:.3f} s after {signal.time[i]:.3f} s; "
            f"up to {LONGEST_HOLE:g} s can be bridged"
        )
    if holes.size:
        longest = step.max()
        _warn(f"{where}: {holes.size} holes of up to {longest:.3f} s in the joint angles, the first after "
              f"{signal.time[holes[0]]:.3f} s, are bridged")  # fmt: skip
    if 1 / usual < SLOW:
        _warn(f"{where}: {slow_rate(1 / usual)}")


def slow_rate(rate_hz: float) -> str:
    """What a low sampling rate of the joint angles means, with numbers."""
    first, second = (rate_hz / mode for mode in MODES)
    return (
        f"joint angles at {rate_hz:.1f} Hz have {first:.1f} samples in a period of {MODES[0]} Hz and {second:.1f} of "
        f"{MODES[1]} Hz (first modes of a 36 m boom, stretched); {SLOW:g} Hz or more resolve what excites them"
    )


def _warn(text: str) -> None:
    warnings.warn(text, LogWarning, stacklevel=3)
