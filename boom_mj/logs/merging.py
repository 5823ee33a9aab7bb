"""Parts that come from different topics or publishers -> one signal; signals of one topic share their times."""

import warnings
from collections.abc import Mapping

import numpy as np

from boom_mj.errors import LogError, LogWarning
from boom_mj.logs.intake import Part
from boom_mj.logs.topics import TOPICS
from boom_mj.recording import QUANTITIES, Signal, align, named_signal

Array = np.ndarray


def merged(name: str, parts: list[Part]) -> Signal:
    """Signal of all its channels; parts with other times are interpolated to those of the slowest one.

    Raises:
        LogError: a channel that no part or several parts give; parts that share no time.
    """
    channels = QUANTITIES[name].channels
    given = [channel for part in parts for channel in part.channels]
    if wrong := [channel for channel in channels if given.count(channel) != 1]:
        origins = ", ".join(part.origin for part in parts)
        raise LogError(f"{', '.join(wrong)} of '{name}' missing or given twice by {origins}")
    moving = [part for part in parts if part.stamps.size]
    if not moving:
        raise LogError(f"'{name}' is constant as a whole; at least one channel must come from a topic")
    base = min(moving, key=lambda part: part.stamps.size)
    start, stop = max(part.stamps[0] for part in moving), min(part.stamps[-1] for part in moving)
    stamps = base.stamps[(base.stamps >= start) & (base.stamps <= stop)]
    if not stamps.size:
        raise LogError(f"the parts of '{name}' share no time: {', '.join(part.origin for part in moving)}")
    if len(moving) == 1 and len(parts) == 1:
        return named_signal(name, stamps / 1e9, base.values)
    columns: dict[str, Array] = {}
    for part in parts:
        values = _at(part, stamps, base, name)
        columns |= dict(zip(part.channels, values.T))
    return named_signal(name, stamps / 1e9, np.stack([columns[channel] for channel in channels], axis=1))


def _at(part: Part, stamps: Array, base: Part, name: str) -> Array:
    if not part.stamps.size:
        return np.repeat(part.values, len(stamps), axis=0)
    if np.isin(stamps, part.stamps, assume_unique=True).all():
        return part.values[np.searchsorted(part.stamps, stamps)]
    warnings.warn(
        f"'{name}': {', '.join(part.channels)} from {part.origin} are interpolated linearly to the times of "
        f"{', '.join(base.channels)} from {base.origin}",
        LogWarning,
        stacklevel=2,
    )
    t, wanted = ((s - stamps[0]) / 1e9 for s in (part.stamps, stamps))
    return np.stack([np.interp(wanted, t, column) for column in part.values.T], axis=1)


def with_shared_times(signals: Mapping[str, Signal]) -> dict[str, Signal]:
    """Signals that one topic of our own logs carries, at the same times, as writing needs them."""
    result = dict(signals)
    for topic in TOPICS:
        names = [name for name in topic.signals.values() if name in result]
        if len(names) == 2 and not np.array_equal(result[names[0]].time, result[names[1]].time):
            first, second = (result[name] for name in names)
            common = np.intersect1d(first.time, second.time)
            if common.size >= 0.5 * min(first.time.size, second.time.size):
                pair = [_picked(signal, common) for signal in (first, second)]
                how = f"keep the {common.size} samples whose times they share"
            else:
                pair, how = list(align(first, second)), "are interpolated to the times of the slower one"
            warnings.warn(f"'{names[0]}' and '{names[1]}' {how}", LogWarning, stacklevel=2)
            result |= dict(zip(names, pair))
    return result


def _picked(signal: Signal, time: Array) -> Signal:
    keep = np.isin(signal.time, time)
    return Signal(signal.time[keep], signal.values[keep], signal.channels, signal.unit, signal.frame)
