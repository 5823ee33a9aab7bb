"""Logs through a channel map, cut into stretches: each is simulated afresh from the state it begins with."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.signal import butter, sosfiltfilt

from boom_mj.errors import LogError
from boom_mj.estimation.blocks import own_noise
from boom_mj.recording import Recording, Signal
from boom_mj.systems.mjcf.channel_map import ChannelEntry
from boom_mj.systems.mjcf.log_table import LogTable, Span, within

Array = np.ndarray
ORDER = 4  # of the Butterworth filter, run both ways
EDGE = 2.0  # periods of the cutoff
MOST_STRETCHES = 10_000
UNEVEN = 0.5  # steps by which stamps may be off even ones to be taken for them
SHORTEST = 0.5  # of a window, below which a rest is left out
SHAKEN = "shaken/"  # measured motion with its noise once more, before the name of its signal
UNSURE = "unsure/"  # standard deviation of a measured state, before its joint


def stretches_of(table: LogTable) -> list[Recording]:
    """A log in stretches of `channels.window` seconds, none of them across a gap.

    Every stretch holds its channels by name, driving motion smooth, of other joints the measured motion "motion/JOINT"
    and the state at its start, "start/JOINT": one sample of position and speed; motion with noise added once more under
    `SHAKEN`, deviations of states under `UNSURE`. Its description is the log's path. A stretch is simulated from
    `channels.settle` before it: what no sensor tells of its beginning is forgotten until then. Where motion drives, a
    smooth motion cannot make the model's forces sharp: compared channels are smoothed, too, by a lower cutoff that
    `MjcfSystem` applies to the model, and what drives reaches some periods beyond what is compared.

    Raises:
        LogError: a log that is too short.
    """
    path, channels, time = table.path, table.channels, table.time
    bridged = {entry.name: table.bridged(entry, table.values[entry.name]) for entry in channels.channel}
    edge = EDGE / channels.cutoff
    margin = edge if channels.driven else 0.0
    motions = _motions(table)
    values = bridged | {motion.entry.name: motion.smooth for motion in motions if motion.entry.role == "drive"}
    for entry in channels.role("compare"):
        if channels.driven:
            values[entry.name] = smoothed(time, values[entry.name], channels.compared_cutoff)
        lost = within(time, table.holes[entry.name], margin) | ~np.isfinite(table.values[entry.name])
        values[entry.name] = np.where(lost, np.nan, values[entry.name])
    known = channels.of_log(path)
    stop = channels.stop if known.stop is None else known.stop
    end = min(time[-1] - margin, stop if stop is not None else np.inf)
    first = max(time[0] + edge, channels.start if known.start is None else known.start)
    if channels.release is not None and table.let_go is not None:
        first = max(first, released(time, table.let_go, channels.release.moves))
    for entry in channels.channel:
        if entry.relative:
            values[entry.name] = values[entry.name] - np.mean(bridged[entry.name][time <= first])
    if end - first > MOST_STRETCHES * channels.window:
        raise LogError(f"{path} lasts {end - first:.4g} s: too long for a window of {channels.window} s")
    spans = [
        (begin, min(begin + channels.window, until))
        for since, until in _between(first, end, table.gaps, edge, margin)
        for begin in np.arange(since + channels.settle, until - SHORTEST * channels.window, channels.window)
    ]
    if not spans:
        after = f" that begins {channels.settle} s late" * bool(channels.settle)
        raise LogError(f"{path} lasts {time[-1] - time[0]:.2f} s: too short for a window of {channels.window} s{after}")
    found = []
    for begin, until in spans:
        early = begin - channels.settle - margin
        inside = (time >= early - 1e-9) & (time < until + margin - 1e-9)
        late = (time >= begin - 1e-9) & (time < until - 1e-9)
        signals = {"start": Signal(np.array([early]), np.zeros((1, 1)), ("start",), "1", "")}
        for entry in channels.channel:
            rows = late if entry.role == "compare" else inside
            signals[entry.name] = Signal(
                time[rows], values[entry.name][rows, None], (entry.name,), entry.unit or "1", entry.place
            )
        for motion in motions:
            signals |= motion.signals(inside)
        name = f"{path.name} {begin:g}-{until:g} s"
        found.append(Recording(name, channels.name, str(path), signals))
    return found


def _between(first: float, end: float, gaps: Sequence[Span], edge: float, margin: float) -> Iterator[Span]:
    """What gaps leave of a log; they are to it as its own ends."""
    for last, until in [*((begin - margin, until) for begin, until in gaps), (end, end)]:
        if first < min(last, end):
            yield first, min(last, end)
        first = max(first, until + edge)


def noise_of(table: LogTable) -> dict[str, float]:
    """Noise per sample of compared channels: what their differences show, and what differs between passes.

    Passes are compared by means over blocks, of which `channels.repeat` should be a whole number; what differs is
    spread over the samples of a block as white noise would be.
    """
    channels, time, found = table.channels, table.time, {}
    count = max(1, round(channels.block_s * (len(time) - 1) / (time[-1] - time[0])))
    for entry in channels.role("compare"):
        values = table.values[entry.name]
        found[entry.name] = _noise(entry, values)
        if channels.repeat is not None:
            lag = round(channels.repeat / channels.block_s)
            means = values[: len(values) // count * count].reshape(-1, count)
            means = np.nanmean(means, axis=1)
            if len(means) < 2 * lag:
                lasts = f"{table.path}: {time[-1] - time[0]:.1f} s"
                raise LogError(f"{lasts} hold no two passes of repeat = {channels.repeat} s")
            between = float(np.nanstd(means[lag:] - means[:-lag]) / np.sqrt(2) * np.sqrt(count))
            found[entry.name] = max(found[entry.name], between)
    return found


def split(recordings: Sequence[Recording], share: float) -> int:
    """How many of a log's stretches, from its start, are for learning, at least one; one is always held out."""
    return int(np.clip(round(share * len(recordings)), 1, max(1, len(recordings) - 1)))


def released(time: Array, values: Array, moves: float) -> float:
    """When something was let go, s: the root of its way grows evenly at first, traced back to zero."""
    way = np.abs(values - np.median(values[: max(5, len(values) // 50)]))
    if not (way > moves).any():
        raise LogError(f"release: nothing moves by {moves}; the largest way is {np.nanmax(way):.3g}")
    at = int(np.argmax(way > moves))
    slope, level = np.polyfit(time[at : at + 3], np.sqrt(way[at : at + 3]), 1)
    return float(np.clip(-level / slope, time[max(at - 3, 0)], time[at]))


def smoothed(time: Array, values: Array, cutoff: float) -> Array:
    """Values through a filter without phase, (n,); unevenly sampled ones on even times."""
    rate = (len(time) - 1) / (time[-1] - time[0])
    if cutoff >= 0.45 * rate or len(time) < 60:
        return values
    even, sections = time[0] + np.arange(len(time)) / rate, butter(ORDER, cutoff, fs=rate, output="sos")
    if np.abs(even - time).max() < UNEVEN / rate:
        return sosfiltfilt(sections, values)
    return np.interp(time, even, sosfiltfilt(sections, np.interp(even, time, values)))


def _noise(entry: ChannelEntry, values: Array) -> float:
    """Of a sample, as declared or as its differences show."""
    return max(entry.noise, own_noise(values))


@dataclass(frozen=True)
class _Motion:
    """Measured motion of a joint, smooth, and the same with its noise once more, (n,) each."""

    entry: ChannelEntry
    time: Array
    smooth: Array
    shaken: Array

    @cached_property
    def state(self) -> Array:
        """Position and speed, (n, 2)."""
        return self._with_speed(self.smooth)

    @cached_property
    def unsure(self) -> Array:
        """Standard deviations of position and speed, (2,)."""
        return np.std(self._with_speed(self.shaken) - self.state, axis=0)

    def _with_speed(self, values: Array) -> Array:
        return np.stack([values, np.gradient(values, self.time)], axis=1)

    def signals(self, rows: Array) -> dict[str, Signal]:
        """What simulations of a stretch take from it; see `stretches_of`."""
        entry, unit, at = self.entry, self.entry.unit or "1", np.argmax(rows)

        def told(rows: Array | slice, values: Array, *names: str) -> Signal:
            return Signal(self.time[rows], values.reshape(-1, len(names)), names, unit, entry.place)

        moved, again = (told(rows, own[rows], entry.joint) for own in (self.smooth, self.shaken))
        if entry.role == "drive":
            return {SHAKEN + entry.name: again}
        if entry.role != "compare" or entry.what != "position":
            return {}
        state, unsure = (told(slice(at, at + 1), own, "position", "velocity") for own in (self.state[at], self.unsure))
        names = f"motion/{entry.joint}", f"{SHAKEN}motion/{entry.joint}", f"start/{entry.joint}", UNSURE + entry.joint
        return dict(zip(names, (moved, again, state, unsure)))


def _motions(table: LogTable) -> list[_Motion]:
    """Of all channels of joints."""
    channels, time = table.channels, table.time
    moving = [entry for entry in channels.channel if entry.joint]
    white = np.random.default_rng(0).normal(size=(len(moving), len(time)))
    found = []
    for entry, noise in zip(moving, white):
        own = table.values[entry.name]
        told = (own, own + noise * _noise(entry, own))
        both = (smoothed(time, table.bridged(entry, one), channels.cutoff) for one in told)
        found.append(_Motion(entry, time, *both))
    return found
