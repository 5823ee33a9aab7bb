"""Recordings as one long vector: all channels averaged over blocks, split into what trains and what is held out.

The noise of a block mean falls with the root of its samples, its rounding with that of the values that they have, and
what no model knows - the first milliseconds after a rope is cut - weighs less. Entries lie recording by recording,
channel by channel.
"""

import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from boom_mj.errors import LogError, LogWarning
from boom_mj.estimation.blocks import block_means, block_numbers, own_noise, rounding_noise
from boom_mj.estimation.channels import Channel, Table
from boom_mj.recording import Recording, Signal, sample, window

Array = np.ndarray
Span = tuple[float, float]  # when a recording begins and how long it lasts, s
RESOLUTION_S = 1e-6  # of stamps since 1970
SCATTER = 1.3  # by which a channel's own estimate of its noise may be too large by chance
CHANCE = 5.0  # over the root of samples, by which that of all channels of a signal may be: three standard deviations


@dataclass(frozen=True, eq=False)
class Dataset:
    """Recordings of one machine.

    Attributes:
        recordings: for training first; without what their compared signals say outside the time that is simulated.
        training: how many are for training; the rest is held out. With all of them for training every recording is
            split in time instead.
        spans: of the recordings.
        channels: all of them, recording by recording.
        block_s: over which channels are averaged.
        correlation_s: beyond which residuals count as independent.
        first: of entries at times (n,), s, in recordings that last (n,) s: which train where their recording does so
            in part, (n,) of bool.
        extended: indices of recordings held out whose first part trains as well.
    """

    recordings: tuple[Recording, ...]
    training: int
    spans: tuple[Span, ...]
    channels: tuple[Channel, ...]
    block_s: float
    correlation_s: float
    first: Callable[[Array, Array], Array]
    extended: frozenset[int] = frozenset()

    def extending(self, index: int) -> "Dataset":
        """The same recordings; the first part of one more trains."""
        return replace(self, extended=self.extended | {index})

    def hiding(self, rows: Array) -> "Dataset":
        """The same recordings as if entries (N,) of bool had not been measured."""
        measured = np.where(rows, np.nan, self.measured)
        seen = (measured[self.stretch(k)] for k in range(len(self.channels)))
        channels = tuple(replace(channel, measured=part) for channel, part in zip(self.channels, seen))
        recordings = tuple(log.with_signals(self._without(k, rows)) for k, log in enumerate(self.recordings))
        return replace(self, recordings=recordings, channels=channels)

    def _without(self, index: int, rows: Array) -> dict[str, Signal]:
        """Signals of a recording that have entries (N,) of bool, hidden."""
        found: dict[str, Signal] = {}
        for number, channel in enumerate(self.channels):
            gone = channel.blocks[rows[self.stretch(number)]]
            if channel.recording == index and gone.size:
                signal = found.get(channel.signal, self.recordings[index][channel.signal])
                values = signal.values.astype(float)
                inside = np.isin(block_numbers(self.elapsed(index, channel.signal), self.block_s), gone)
                values[inside, channel.column] = np.nan
                found[channel.signal] = replace(signal, values=values)
        return found

    def alone(self, index: int, since_s: float = 0.0) -> "Dataset":
        """One recording from a moment on, split in time."""
        own = self.of(index)
        seen = [np.where(channel.time < since_s, np.nan, channel.measured) for channel in own]
        return replace(
            self,
            recordings=(self.recordings[index],),
            training=1,
            spans=(self.spans[index],),
            channels=tuple(replace(channel, recording=0, measured=part) for channel, part in zip(own, seen)),
            first=lambda time, lasts: self.first(time - since_s, lasts - since_s),
            extended=frozenset(),
        )

    @property
    def trained(self) -> tuple[int, ...]:
        """Indices of the recordings that train, wholly or in part."""
        return (*range(self.training), *sorted(self.extended))

    @property
    def split_in_time(self) -> bool:
        """Whether no recording is held out whole."""
        return self.training == len(self.recordings)

    @cached_property
    def offsets(self) -> Array:
        """Where each channel begins in the long vector, and its end, (channels + 1,)."""
        return np.cumsum([0, *(len(channel.time) for channel in self.channels)])

    def stretch(self, number: int) -> slice:
        """Where a channel lies in the long vector."""
        return slice(int(self.offsets[number]), int(self.offsets[number + 1]))

    def rows(self, index: int) -> slice:
        """Where a recording lies in the long vector."""
        own = [k for k, channel in enumerate(self.channels) if channel.recording == index]
        return slice(self.stretch(own[0]).start, self.stretch(own[-1]).stop)

    def of(self, index: int) -> list[Channel]:
        """Channels of a recording."""
        return [channel for channel in self.channels if channel.recording == index]

    def spread(self, values: Sequence[float]) -> Array:
        """One value per channel, repeated over its blocks, (N,)."""
        return np.repeat(np.asarray(values, float), np.diff(self.offsets))

    @cached_property
    def channel_of(self) -> Array:
        """Number of the channel of every entry, (N,)."""
        return self.spread(range(len(self.channels))).astype(int)

    @cached_property
    def recording_of(self) -> Array:
        """Index of the recording of every entry, (N,)."""
        return self.spread([channel.recording for channel in self.channels]).astype(int)

    @cached_property
    def time(self) -> Array:
        """(N,), s from the start of its recording."""
        return np.concatenate([channel.time for channel in self.channels])

    @cached_property
    def moments_of(self) -> list[tuple[Array, Array]]:
        """Of every recording the moments of its entries, (m,), s, and the number of each entry's, (n,)."""
        return [np.unique(self.time[self.rows(k)], return_inverse=True) for k in range(len(self.recordings))]

    @cached_property
    def measured(self) -> Array:
        """(N,); NaN where hidden."""
        return np.concatenate([channel.measured for channel in self.channels])

    @cached_property
    def noise(self) -> Array:
        """Standard deviation of every block mean, (N,)."""
        return np.concatenate([channel.deviation for channel in self.channels])

    @cached_property
    def used(self) -> Array:
        """Entries that were measured, (N,) of bool."""
        return np.isfinite(self.measured)

    @cached_property
    def train(self) -> Array:
        """Entries that train, (N,) of bool."""
        first = self.first(self.time, np.array([self.duration(k) for k in self.recording_of]))
        whole = (self.recording_of < self.training) & (not self.split_in_time)
        return self.used & np.isin(self.recording_of, self.trained) & (whole | first)

    @cached_property
    def held_out(self) -> Array:
        """Entries that are held out, (N,) of bool."""
        return self.used & ~self.train

    @cached_property
    def windows(self) -> Array:
        """Number of the window of independence of every entry, across recordings, (N,)."""
        per_recording = int(max(self.time) // self.correlation_s) + 1
        return (self.recording_of * per_recording + self.time // self.correlation_s).astype(int)

    def moments(self, repeat_s: float) -> Array:
        """Number of the window within its pass of every entry, alike in all passes of a motion that repeats, (N,)."""
        begin = np.array([start for start, _ in self.spans])
        return ((self.time + begin[self.recording_of]) % repeat_s // self.correlation_s).astype(int)

    def duration(self, index: int) -> float:
        """Of a recording, s."""
        return self.spans[index][1]

    def blurred(self, vector: Array, length_s: float) -> Array:
        """The means of a vector's measured entries (N,) over stretches of every channel."""
        stretch = (self.time // length_s).astype(int)
        stretch += self.channel_of * (stretch.max() + 1)
        total, count = np.bincount(stretch, vector * self.used), np.bincount(stretch, self.used)
        return np.where(self.used, (total / np.maximum(count, 1))[stretch], 0.0)

    def stacked(self, parts: Mapping[int, Array]) -> Array:
        """The long vector (N,) of what recordings say, by index; NaN for the others."""
        vector = np.full(int(self.offsets[-1]), np.nan)
        for index, part in parts.items():
            vector[self.recording_of == index] = part
        return vector

    def table(self, index: int) -> Table:
        """A recording's channels on one grid of blocks."""
        (_, duration), channels = self.spans[index], tuple(self.of(index))
        rows = int(np.floor(duration / self.block_s + 1e-6)) + 1
        noise = np.tile([channel.noise for channel in channels], (rows, 1))
        for column, channel in enumerate(channels):
            noise[channel.blocks, column] = channel.deviation
        time = (np.arange(rows) + 0.5) * self.block_s
        empty = Table(self.recordings[index], channels, self.spans[index][0], time, np.zeros((rows, 0)), noise)
        return empty.saying(np.concatenate([channel.measured for channel in channels]))

    def elapsed(self, index: int, signal: str) -> Array:
        """Times of a recording's signal from its start, (n,), s."""
        return self.recordings[index][signal].time - self.spans[index][0]

    def means(self, index: int, name: str, dense: Signal) -> Array:
        """Block means of a simulated signal where a recording has samples, channel by channel; NaN where hidden."""
        elapsed, hidden = self.elapsed(index, name), np.isnan(self.recordings[index][name].values)
        values = np.where(hidden, np.nan, sample(dense, elapsed))
        return block_means(elapsed, values, self.block_s)[2].T.ravel()

    def gapless_means(self, index: int, name: str, dense: Signal) -> Array:
        """As `means`, of every block up to a channel's last; blocks without a sample have as many as others."""
        elapsed, block = self.elapsed(index, name), self.block_s
        within = np.arange(0, block * (1 - 1e-6), float(np.median(np.diff(elapsed, append=elapsed[-1] + block))))
        missing = np.setdiff1d(np.arange(int(elapsed[-1] / block + 1e-6)), block_numbers(elapsed, block))
        elapsed = np.union1d(elapsed, (missing[:, None] * block + within).ravel())
        return block_means(elapsed, sample(dense, elapsed), block)[2].T.ravel()


def make_dataset(
    recordings: Sequence[Recording],
    training: int,
    spans: Sequence[Span],
    noise: Mapping[str, Array],
    group: Callable[[str, int], str],
    block_s: float,
    correlation_s: float,
    first: Callable[[Array, Array], Array],
    raised: Sequence[Mapping[str, Array]] = (),
) -> Dataset:
    """A dataset of the signals that have noise; for the rest see `Dataset`.

    Args:
        noise: least noise of a sample by signal, one per channel, (k,).
        group: of a signal's column.
        raised: by recording, noise of signals (k,) that is known to be more.

    Raises:
        LogError: nothing to train with, or a signal that shares no time with what drives the model.
    """
    if not recordings or training < 1:
        raise LogError("a diagnosis needs at least one recording to learn from")
    cut = tuple(_while_driven(log, span, noise) for log, span in zip(recordings, spans))
    noise = {s: levels * _louder([log[s] for log in cut if s in log], levels) for s, levels in noise.items()}
    channels = []
    for index, log in enumerate(cut):
        for name, levels in noise.items():
            if name not in log:
                continue
            elapsed, values = log[name].time - spans[index][0], log[name].values
            more = raised[index].get(name) if raised else None
            least = np.asarray(levels) if more is None else np.maximum(levels, more)
            blocks = np.unique(block_numbers(elapsed, block_s))
            for column in range(values.shape[1]):
                time, count, mean = block_means(elapsed, values[:, column], block_s)
                level = max(float(least[column]), own_noise(values[:, column]) / SCATTER)
                rounding = rounding_noise(elapsed, values[:, column], block_s)
                kind = group(name, column)
                channels.append(Channel(index, name, column, kind, blocks, time, count, mean, level, rounding))
    return Dataset(cut, training, tuple(spans), tuple(channels), block_s, correlation_s, first)


def _louder(signals: Sequence[Signal], least: Array) -> float:
    """By how much what all channels of a signal scatter by exceeds its least noise (k,), beyond chance; 1 at least."""
    own = [own_noise(values) / level for s in signals for values, level in zip(s.values.T, least) if level > 0]
    samples = sum(np.isfinite(signal.values).sum() for signal in signals)
    return max(1.0, float(np.median(own)) / (1 + CHANCE / np.sqrt(samples))) if own else 1.0


def _while_driven(log: Recording, span: Span, names: Mapping[str, Array]) -> Recording:
    """A recording whose compared signals are cut to the time that is simulated; a warning says by how much."""
    begin, duration = span
    end, cut, outside = begin + duration, {}, []
    for name in names:
        if name in log:
            signal, early, late = log[name], begin - log[name].time[0], log[name].time[-1] - end
            if early > 0 or late > RESOLUTION_S:
                cut[name] = window(signal, begin, end + RESOLUTION_S)
                outside.append((len(signal.time) - len(cut[name].time), name, max(early, late)))
    if not cut:
        return log
    most, (name, *others) = max(seconds for *_, seconds in outside), [name for _, name, _ in outside]
    warnings.warn(
        f"{log.name}: {sum(count for count, *_ in outside)} samples of {name}"
        f"{f' and {len(others)} other signals' if others else ''} lie up to {most:.3f} s outside the "
        f"{begin:.3f} to {end:.3f} s that drive the model and are left out",
        LogWarning,
        stacklevel=3,
    )
    return replace(log, signals={**log.signals, **cut})
