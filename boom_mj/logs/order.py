"""Times of a topic: late messages are put in their place, repeated ones dropped, clock resets refused."""

import warnings

import numpy as np

from boom_mj.errors import LogError, LogWarning

Array = np.ndarray

LATE = 0.1  # s, by which a message may come too late and still be put in its place
FEW, ROOM = (
    0.05,
    0.5,
)  # share of later ones, usual steps that each finds free in its place: a reset clock says all twice


def in_order(stamps: Array, values: Array, topic: str) -> tuple[Array, Array]:
    """Samples in the order of their times, each time once.

    Args:
        stamps: (n,), ns.
        values: (n, k).

    Raises:
        LogError: a clock that was set back, or different samples at the same time.
    """
    if len(stamps) > 1 and not stamps.any():
        raise LogError('all header stamps are 0; say time = "log" in a topic map to use the times of recording')
    stamps, values = put_in_place(stamps, values, topic, 'say time = "log" in a topic map')
    again = np.flatnonzero(np.diff(stamps) == 0) + 1
    if again.size:
        differs = again[(~np.isclose(values[again], values[again - 1], 0, 0, equal_nan=True)).any(axis=1)]
        if differs.size:
            t = stamps[differs[0]] / 1e9
            raise LogError(f"times must increase, but {t:.9f} s is followed by {t:.9f} s with other values")
        _warn(f"{topic}: {again.size} repeated messages are dropped, the first at {stamps[again[0]] / 1e9:.3f} s")
        keep = np.ones(len(stamps), bool)
        keep[again] = False
        stamps, values = stamps[keep], values[keep]
    return stamps, values


def put_in_place(stamps: Array, values: Array, topic: str, advice: str) -> tuple[Array, Array]:
    """Samples in the order of their times; see `in_order`.

    Args:
        advice: how to use the times of recording.
    """
    step = np.diff(stamps)
    if (step < 0).any():
        i = int(np.argmin(step))
        if -step[i] > LATE * 1e9 and not _late_ones(stamps):
            i = int(np.flatnonzero(step < -LATE * 1e9)[0])
            raise LogError(
                f"the clock was set back: {stamps[i] / 1e9:.9f} s is followed by {stamps[i + 1] / 1e9:.9f} s; "
                f"{advice} if the times of recording are sound"
            )
        _warn(f"{topic}: {(step < 0).sum()} messages, up to {-step[i] / 1e6:.1f} ms late, are put in their place")
        order = np.argsort(stamps, kind="stable")
        stamps, values = stamps[order], values[order]
    return stamps, values


def _late_ones(stamps: Array) -> bool:
    """Whether stamps that go back are of few messages recorded late, whose places between the others are free."""
    late = stamps < np.maximum.accumulate(stamps)
    steps = np.diff(np.sort(stamps))
    return bool(late.mean() <= FEW and steps.min() > ROOM * np.median(steps))


def _warn(text: str) -> None:
    warnings.warn(text, LogWarning, stacklevel=3)
