"""What a system says of recordings under any hypothesis: simulated on threads, each at most once."""

import os
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from copy import copy
from threading import Lock

import numpy as np

from boom_mj.effects import is_output
from boom_mj.errors import BoomError
from boom_mj.estimation.dataset import Dataset, make_dataset
from boom_mj.recording import Recording, Signal, sample
from boom_mj.systems.fidelity import Level
from boom_mj.systems.system import Hypothesis, System

Array = np.ndarray
KEPT = 1500  # predictions of single recordings, some 0.2 MB each
SHARED = 4  # hypotheses whose dense simulations are kept, for others that differ in their sensors only


def dataset_of(
    system: System, recordings: Sequence[Recording], training: int, raised: Sequence[Mapping[str, Array]] = ()
) -> Dataset:
    """Recordings of a system as its channels are compared; see `make_dataset`."""
    facts, timelines = system.facts, [system.timeline(log) for log in recordings]
    return make_dataset(
        recordings,
        training,
        [(line.start_s, line.duration_s) for line in timelines],
        facts.noise,
        lambda signal, column: system.channel(signal, column).group,
        facts.block_s,
        facts.correlation_s,
        facts.split,
        raised,
    )


class Predictor:
    """A cache of simulations of a dataset's recordings.

    Args:
        system: the machine, nominal.
        data: its recordings.
        threads: simulations at a time.
    """

    def __init__(self, system: System, data: Dataset, threads: int | None = None):
        self.system, self.data = system, data
        threads = threads or os.cpu_count() or 1
        self._pool = ThreadPoolExecutor(threads)
        self._kept = SHARED * len(data.recordings) + threads
        self._simulated_s: list[float] = []
        self._futures: dict[tuple, Future[Array]] = {}  # of predictions, the latest asked for last
        self._dense: dict[tuple, Future[dict[str, Signal]]] = {}  # the latest asked for last
        self._parts: dict[tuple, Array] = {}
        self._lock = Lock()
        fidelity = system.facts.fidelity
        self._shared = {fidelity.rough, fidelity.coarse}  # levels at which nominal simulations serve output effects

    def extending(self, index: int) -> "Predictor":
        """With the first part of one more recording for training; what was simulated is known."""
        return self._of(self.data.extending(index))

    def hiding(self, rows: Array) -> "Predictor":
        """As if entries (N,) of bool had not been measured; what was simulated is known."""
        return self._of(self.data.hiding(rows))

    def _of(self, data: Dataset) -> "Predictor":
        other = copy(self)
        other.data = data
        return other

    @property
    def simulated_s(self) -> float:
        """Simulated seconds so far."""
        return sum(self._simulated_s)

    def predict(
        self, hypotheses: Sequence[Hypothesis], level: Level, recordings: Sequence[int] | None = None
    ) -> list[Array]:
        """The long vector of every hypothesis, (N,) each; NaN where not asked for, or where a simulation failed.

        Args:
            recordings: indices of those asked for; all if left out.
        """
        futures = self._begin(hypotheses, level, recordings)
        return [self.data.stacked({k: part.result() for k, part in parts.items()}) for parts in futures]

    def predictions(
        self, hypotheses: Sequence[Hypothesis], level: Level, recordings: Sequence[int] | None = None
    ) -> Iterator[Array]:
        """As `predict`, one after the other, each forgotten once it was asked for; all are begun at once."""
        futures = self._begin(hypotheses, level, recordings)
        for hypothesis, parts in zip(hypotheses, futures):
            yield self.data.stacked({k: part.result() for k, part in parts.items()})
            with self._lock:
                for index in parts:
                    self._futures.pop((frozenset(hypothesis), level, index, False), None)
            parts.clear()

    def ahead(self, hypotheses: Sequence[Hypothesis], *levels: Level) -> None:
        """Begin what will soon be predicted at several levels, so that no thread waits for the last of a batch."""
        for level in levels:
            self._begin(hypotheses, level, None)

    def _begin(
        self, hypotheses: Sequence[Hypothesis], level: Level, recordings: Sequence[int] | None
    ) -> list[dict[int, Future[Array]]]:
        """Predictions of every hypothesis by recording; the longest are simulated first."""
        indices = range(len(self.data.recordings)) if recordings is None else recordings
        longest = sorted(indices, key=self.data.duration, reverse=True)  # first, so that threads end together
        alike: dict[frozenset, list[int]] = {}  # those that differ in their sensors only go together
        for number, hypothesis in enumerate(hypotheses):
            alike.setdefault(frozenset(simulated(hypothesis)), []).append(number)
        order = [number for numbers in alike.values() for number in numbers]
        begun = {number: {k: self.begin(hypotheses[number], level, k) for k in longest} for number in order}
        return [begun[number] for number in range(len(hypotheses))]

    def begin(self, hypothesis: Hypothesis, level: Level, index: int, gapless: bool = False) -> Future[Array]:
        """The prediction of one recording, (n,); see `predict`.

        Args:
            gapless: of every block up to a channel's last, hidden and missing ones too.
        """
        key = (frozenset(hypothesis), level, index, gapless)
        with self._lock:
            future = self._futures.pop(key, None) or self._pool.submit(self._block_means, *key[1:], hypothesis)
            self._futures[key] = future
            if len(self._futures) > KEPT:
                del self._futures[next(iter(self._futures))]
            return future

    def recorded(self, hypothesis: Hypothesis, level: Level, index: int) -> dict[str, Array]:
        """What the sensors of a hypothesis would have said, by signal, at the log's own times, (n, k) each.

        Raises:
            EquilibriumError, SimulationError: the hypothesis is none.
        """
        signals, log = self._signals(hypothesis, level, index)[1], self.data.recordings[index]
        return {name: sample(signals[name], self.data.elapsed(index, name)) for name in signals if name in log}

    def _block_means(self, level: Level, index: int, gapless: bool, hypothesis: Hypothesis) -> Array:
        channels = self.data.of(index)
        try:
            dense, signals = self._signals(hypothesis, level, index)
        except BoomError:
            return np.full(sum(c.blocks[-1] + 1 if gapless else len(c.time) for c in channels), np.nan)
        healthy = not simulated(hypothesis)
        parts = []
        for name in dict.fromkeys(channel.signal for channel in channels):
            if gapless:
                parts.append(self.data.gapless_means(index, name, signals[name]))
                continue
            key = (level, index, name) if healthy and signals[name] is dense[name] else None
            means = self._parts.get(key) if key else None
            means = self.data.means(index, name, signals[name]) if means is None else means
            if key:
                self._parts[key] = means
            parts.append(means)
        return np.concatenate(parts)

    def _signals(self, hypothesis: Hypothesis, level: Level, index: int) -> tuple[dict[str, Signal], dict[str, Signal]]:
        """Densely sampled signals of healthy sensors, and of those of the hypothesis."""
        dense = self._dense_signals(simulated(hypothesis), level, index)
        return dense, self.system.observe(tuple(e for e in hypothesis if is_output(e)), dense)

    def _dense_signals(self, hypothesis: Hypothesis, level: Level, index: int) -> dict[str, Signal]:
        """Simulated once, whoever else asks meanwhile; the nominal machine's rough ones stay, others for a while."""
        key = (frozenset(hypothesis), level, index)
        with self._lock:
            known = self._dense.pop(key, None)
            future = self._dense[key] = known or Future()
            passing = [k for k in self._dense if k[0] or k[1] not in self._shared]
            if len(passing) > self._kept:
                del self._dense[passing[0]]
        if known is None:
            try:
                signals = self.system.simulate(hypothesis, level, self.data.recordings[index])
            except BaseException as error:
                future.set_exception(error)
            else:
                with self._lock:
                    self._simulated_s.append(max(signal.time[-1] for signal in signals.values()))
                future.set_result(signals)
        return future.result()


def simulated(hypothesis: Hypothesis) -> Hypothesis:
    """Effects that need a simulation of their own; the others alter simulated signals afterwards."""
    return tuple(effect for effect in hypothesis if not is_output(effect))
