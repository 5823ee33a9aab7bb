"""A campaign: the recordings of one machine, and what the model says of them under any hypothesis.

Every hypothesis is a tuple of effects. Its prediction is one long vector: all channels of all recordings, averaged over
blocks of some samples: the noise falls. Simulations run on threads, each at most once.
"""

import os
import warnings
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from copy import copy
from dataclasses import dataclass, replace
from functools import cached_property
from threading import Lock

import numpy as np

from boom_mj.errors import BoomError, LogError, LogWarning
from boom_mj.machine import Machine
from boom_mj.recording import Recording, Signal, window
from boom_mj.sensors import sample
from boom_mj.sensors.blocks import block_means, block_numbers, own_noise
from boom_mj.systems.boom.system import BoomSystem
from boom_mj.systems.system import Hypothesis, Level, System

Array = np.ndarray
KEPT = 1500  # predictions of single recordings, some 0.2 MB each
RESOLUTION = 1e-6  # s, of stamps since 1970
SHARED = 4  # hypotheses whose dense simulations are kept, for others that differ in their sensors only


@dataclass(frozen=True)
class Channel:
    """One channel of one recording, its stretch of the long vector.

    Attributes:
        recording: index.
        signal, column: where the channel lies in the recording.
        group: sensor and direction, such as "imu/link5/specific_force/y" or "markers/link4/z".
        blocks: numbers of those that were sampled, (n,) of int.
        time: of their middles, (n,), s from the start of the recording.
        count: samples of a block, (n,); 0 where all are hidden.
        measured: means of its blocks, (n,).
        noise: of a single sample.
    """

    recording: int
    signal: str
    column: int
    group: str
    blocks: Array
    time: Array
    count: Array
    measured: Array
    noise: float


class Campaign:
    """Recordings of a machine and a cache of simulations of them.

    Args:
        subject: the machine, nominal; a machine file stands for its boom.
        recordings: for training first.
        training: how many of them are for training; the rest is held out. With all of them for training every
            recording is split in time instead.
        threads: simulations at a time.

    Attributes:
        recordings: without what their compared signals say outside the time that is simulated.
        borrowed: indices of recordings held out whose first part is learnt from as well.

    Raises:
        LogError: nothing to learn from, or a signal that shares no time with what drives the model.
    """

    def __init__(
        self,
        subject: System | Machine,
        recordings: Sequence[Recording],
        training: int,
        threads: int | None = None,
    ):
        if not recordings or training < 1:
            raise LogError("a diagnosis needs at least one recording to learn from")
        self.subject = subject if isinstance(subject, System) else BoomSystem(subject)
        self.recordings = tuple(_while_driven(self.subject, log) for log in recordings)
        self.training = training
        threads = threads or os.cpu_count() or 1
        self.pool = ThreadPoolExecutor(threads)
        self.kept = SHARED * len(recordings) + threads
        self.borrowed: frozenset[int] = frozenset()
        self._simulated_s: list[float] = []
        self._futures: dict[tuple, Future[Array]] = {}  # of predictions, the latest asked for last
        self._dense: dict[tuple, Future[dict[str, Signal]]] = {}  # the latest asked for last
        self._parts: dict[tuple, Array] = {}
        self._lock = Lock()
        self.channels = tuple(channel for index in range(len(recordings)) for channel in self._channels(index))

    def borrowing(self, index: int) -> "Campaign":
        """The same recordings; of one more the first part is learnt from. What was simulated is known."""
        other = copy(self)
        other.borrowed = self.borrowed | {index}
        for name in ("train", "held_out"):
            vars(other).pop(name, None)
        return other

    @property
    def learning(self) -> tuple[int, ...]:
        """Indices of the recordings that are learnt from, wholly or in part."""
        return (*range(self.training), *sorted(self.borrowed))

    @property
    def simulated_s(self) -> float:
        """Simulated seconds so far."""
        return sum(self._simulated_s)

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

    def blurred(self, vector: Array, length: float) -> Array:
        """The means of a vector's measured entries (N,) over stretches of so many seconds of every channel."""
        stretch = (self.time // length).astype(int)
        stretch += self.channel_of * (stretch.max() + 1)
        total, count = np.bincount(stretch, vector * self.used), np.bincount(stretch, self.used)
        return np.where(self.used, (total / np.maximum(count, 1))[stretch], 0.0)

    @cached_property
    def time(self) -> Array:
        """(N,), s from the start of its recording."""
        return np.concatenate([channel.time for channel in self.channels])

    @cached_property
    def measured(self) -> Array:
        """(N,); NaN where hidden."""
        return np.concatenate([channel.measured for channel in self.channels])

    @cached_property
    def noise(self) -> Array:
        """Standard deviation of every block mean, (N,)."""
        count = np.concatenate([channel.count for channel in self.channels])
        return self.spread([channel.noise for channel in self.channels]) / np.sqrt(np.maximum(count, 1))

    @cached_property
    def used(self) -> Array:
        """Entries that were measured, (N,) of bool."""
        return np.isfinite(self.measured)

    @cached_property
    def train(self) -> Array:
        """Entries to learn from, (N,) of bool."""
        lasts = np.array([self.duration(index) for index in range(len(self.recordings))])
        first = self.subject.learns(self.time, lasts[self.recording_of])
        whole = (self.recording_of < self.training) & (not self.split_in_time)
        return self.used & np.isin(self.recording_of, self.learning) & (whole | first)

    @cached_property
    def held_out(self) -> Array:
        """Entries to judge by, (N,) of bool."""
        return self.used & ~self.train

    def duration(self, index: int) -> float:
        """Of a recording, s."""
        return self.subject.clock(self.recordings[index])[1]

    def predict(self, hypotheses: Sequence[Hypothesis], level: Level, training_only: bool = False) -> list[Array]:
        """The long vector of every hypothesis, (N,) each; NaN where not asked for, or where MuJoCo left the numbers.

        Args:
            level: of fidelity.
            training_only: leave out recordings that are held out whole.
        """
        return list(self.predictions(hypotheses, level, training_only))

    def predictions(
        self, hypotheses: Sequence[Hypothesis], level: Level, training_only: bool = False
    ) -> Iterator[Array]:
        """As `predict`, one after the other: all are begun at once, and each is there when it is asked for."""
        futures = self._begin(hypotheses, level, training_only)
        return (self._stack({k: part.result() for k, part in parts.items()}) for parts in futures)

    def ahead(self, hypotheses: Sequence[Hypothesis], *levels: Level) -> None:
        """Begin what will soon be predicted at several levels, so that no thread waits for the last of a batch."""
        for level in levels:
            self._begin(hypotheses, level)

    def _begin(
        self, hypotheses: Sequence[Hypothesis], level: Level, training_only: bool = False
    ) -> list[dict[int, Future[Array]]]:
        """Predictions of every hypothesis by recording; the longest are simulated first."""
        indices = self.learning if training_only else range(len(self.recordings))
        longest = sorted(indices, key=self.duration, reverse=True)  # first, so that threads end together
        alike: dict[frozenset, list[int]] = {}  # those that differ in their sensors only go together
        for number, hypothesis in enumerate(hypotheses):
            alike.setdefault(frozenset(self.subject.split(hypothesis)[0]), []).append(number)
        order = [number for numbers in alike.values() for number in numbers]
        begun = {number: {k: self.begin(hypotheses[number], level, k) for k in longest} for number in order}
        return [begun[number] for number in range(len(hypotheses))]

    def _stack(self, parts: Mapping[int, Array]) -> Array:
        vector = np.full(int(self.offsets[-1]), np.nan)
        for index, part in parts.items():
            vector[self.recording_of == index] = part
        return vector

    def begin(self, hypothesis: Hypothesis, level: Level, index: int, gapless: bool = False) -> Future[Array]:
        """The prediction of one recording, (n,); see `predict`.

        Args:
            gapless: of every block up to a channel's last, hidden and missing ones too.
        """
        key = (frozenset(hypothesis), level, index, gapless)
        with self._lock:
            future = self._futures.pop(key, None) or self.pool.submit(self._block_means, *key[1:], hypothesis)
            self._futures[key] = future
            if len(self._futures) > KEPT:
                del self._futures[next(iter(self._futures))]
            return future

    def _block_means(self, level: Level, index: int, gapless: bool, hypothesis: Hypothesis) -> Array:
        channels = [channel for channel in self.channels if channel.recording == index]
        try:
            dense, signals = self._signals(hypothesis, level, index)
        except BoomError:
            return np.full(sum(c.blocks[-1] + 1 if gapless else len(c.time) for c in channels), np.nan)
        healthy = not self.subject.split(hypothesis)[0]
        parts = []
        for name in dict.fromkeys(channel.signal for channel in channels):
            if gapless:
                parts.append(self._gapless_means(index, name, signals[name]))
                continue
            key = (level, index, name) if healthy and signals[name] is dense[name] else None
            parts.append(self._means(index, name, signals[name], key))
        return np.concatenate(parts)

    def _gapless_means(self, index: int, name: str, signal: Signal) -> Array:
        """Block means of a signal's channels, one after the other; blocks without a sample have as many as others."""
        elapsed, block = self._elapsed(index, name), self.subject.block
        within = np.arange(0, block * (1 - 1e-6), float(np.median(np.diff(elapsed, append=elapsed[-1] + block))))
        missing = np.setdiff1d(np.arange(int(elapsed[-1] / block + 1e-6)), block_numbers(elapsed, block))
        elapsed = np.union1d(elapsed, (missing[:, None] * block + within).ravel())
        return block_means(elapsed, sample(signal, elapsed), block)[2].T.ravel()

    def _means(self, index: int, name: str, signal: Signal, key: tuple | None) -> Array:
        """Block means of a signal's channels, one after the other, NaN where hidden; kept under the key, if any."""
        if key is not None and key in self._parts:
            return self._parts[key]
        elapsed, hidden = self._elapsed(index, name), np.isnan(self.recordings[index][name].values)
        values = np.where(hidden, np.nan, sample(signal, elapsed))
        means = block_means(elapsed, values, self.subject.block)[2].T.ravel()
        if key is not None:
            self._parts[key] = means
        return means

    def twin(self, hypothesis: Hypothesis, level: Level, index: int) -> dict[str, Array]:
        """What the sensors of a hypothesis would have said, by signal, at the log's own times, (n, k) each.

        Raises:
            EquilibriumError, SimulationError: the hypothesis is none.
        """
        signals = self._signals(hypothesis, level, index)[1]
        log = self.recordings[index]
        return {name: sample(signals[name], self._elapsed(index, name)) for name in signals if name in log}

    def _signals(self, hypothesis: Hypothesis, level: Level, index: int) -> tuple[dict[str, Signal], dict[str, Signal]]:
        """Densely sampled signals of healthy sensors, and of those of the hypothesis."""
        simulated, sensing = self.subject.split(hypothesis)
        dense = self._dense_signals(simulated, level, index)
        return dense, self.subject.altered(sensing, dense)

    def _dense_signals(self, hypothesis: Hypothesis, level: Level, index: int) -> dict[str, Signal]:
        """Simulated once, whoever else asks meanwhile; those of the nominal machine stay, others for a while."""
        key = (frozenset(hypothesis), level, index)
        with self._lock:
            known = self._dense.pop(key, None)
            future = self._dense[key] = known or Future()
            passing = [k for k in self._dense if k[0]]
            if len(passing) > self.kept:
                del self._dense[passing[0]]
        if known is None:
            try:
                signals = self.subject.simulate(hypothesis, level, index, self.recordings[index])
            except BaseException as error:
                future.set_exception(error)
            else:
                with self._lock:
                    self._simulated_s.append(max(signal.time[-1] for signal in signals.values()))
                future.set_result(signals)
        return future.result()

    def _elapsed(self, index: int, signal: str) -> Array:
        log = self.recordings[index]
        return log[signal].time - self.subject.clock(log)[0]

    def _channels(self, index: int) -> list[Channel]:
        found, log = [], self.recordings[index]
        for name, levels in self.subject.noise().items():
            if name not in log:
                continue
            elapsed, values = self._elapsed(index, name), log[name].values
            blocks = np.unique(block_numbers(elapsed, self.subject.block))
            for column in range(values.shape[1]):
                time, count, mean = block_means(elapsed, values[:, column], self.subject.block)
                noise = max(float(levels[column]), own_noise(values[:, column]) / 1.3)
                group = self.subject.group(name, log[name], column)
                found.append(Channel(index, name, column, group, blocks, time, count, mean, noise))
        return found


def _while_driven(subject: System, log: Recording) -> Recording:
    """A recording whose compared signals are cut to the time that is simulated; a warning says by how much."""
    begin, duration = subject.clock(log)
    end, cut, outside = begin + duration, {}, []
    for name in subject.noise():
        if name in log:
            signal, early, late = log[name], begin - log[name].time[0], log[name].time[-1] - end
            if early > 0 or late > RESOLUTION:
                cut[name] = window(signal, begin, end + RESOLUTION)
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
