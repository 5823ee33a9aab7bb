"""What checks look at: the recordings as they are after the checks before, noise, and what the nominal model says."""

from collections.abc import Iterator, Sequence
from functools import cached_property

import numpy as np

from boom_mj.errors import BoomError
from boom_mj.machine import Machine
from boom_mj.recording import Recording, Signal
from boom_mj.replay.quality.edits import DRIVE
from boom_mj.replay.quality.finding import Action, DataFinding, Repair
from boom_mj.replay.replay import Replay, replay
from boom_mj.sensors import ideal_signals, noise_levels, sample, sample_rates
from boom_mj.simulation import Plant, make_plant

Array = np.ndarray
COMMAND = "joint_command"


class Evidence:
    """A set of recordings.

    Args:
        machine: nominal.
        recordings: for training first.
        names: of the recordings, in findings.
        training: how many are for training.

    Attributes:
        recordings: as they are now; checks replace them.
        left_out: indices of recordings that are not to be used at all.
    """

    def __init__(self, machine: Machine, recordings: Sequence[Recording], names: Sequence[str], training: int) -> None:
        self.machine, self.names, self.training = machine, tuple(names), training
        self.recordings = list(recordings)
        self.left_out: set[int] = set()
        self.levels = noise_levels(machine)
        self.rates = sample_rates(machine)
        self._twins: dict[tuple[int, ...], tuple[Recording, Replay | None]] = {}
        self._dense: dict[int, dict[str, Signal]] = {}
        self._sampled: dict[tuple[int, str, int, float], Array] = {}
        self._kept: list[Recording] = []

    @property
    def indices(self) -> tuple[int, ...]:
        """Of the recordings that are used."""
        return tuple(k for k in range(len(self.recordings)) if k not in self.left_out)

    def measured(self, index: int) -> tuple[str, ...]:
        """Names of a recording's signals that have noise, joint angles among them."""
        log = self.recordings[index]
        return tuple(name for name in self.levels if name in log)

    def sensors(self, index: int) -> dict[str, list[str]]:
        """Sensor -> names of its signals, of all that a recording has."""
        found: dict[str, list[str]] = {}
        for name in self.recordings[index].signals:
            found.setdefault(sensor_of(name), []).append(name)
        return found

    def noise(self, name: str) -> Array:
        """Standard deviation of a signal's channels, (k,), of the machine file."""
        return np.asarray(self.levels[name], float)

    def start(self, index: int) -> float:
        """Stamp from which times in findings count: of the first joint angle, or of the first sample of all."""
        log = self.recordings[index]
        if DRIVE in log:
            return float(log[DRIVE].time[0])
        return min((float(s.time[0]) for s in log.signals.values()), default=0.0)

    @cached_property
    def plant(self) -> Plant:
        """The nominal model, as coarse as it may be: what is compared differs by more than its error."""
        return make_plant(self.machine, 1)

    def twin(self, index: int) -> Replay | None:
        """What the nominal model says of a recording; None where its joint angles cannot drive it."""
        log = self.recordings[index]
        driving = [log.signals.get(name) for name in (DRIVE, f"{COMMAND}/position", "load")]
        key = tuple(map(id, driving))
        if key not in self._twins:
            try:
                found = replay(self.plant, log)
            except BoomError:
                found = None
            self._twins[key] = (log, found)
        return self._twins[key][1]

    def predicted(self, index: int, name: str, lag: float = 0.0) -> Array | None:
        """A signal as the nominal model predicts it at the recording's own stamps, (n, k), stamped late by `lag` s."""
        twin, log = self.twin(index), self.recordings[index]
        if twin is None or name not in log:
            return None
        if id(twin) not in self._dense:
            self._dense[id(twin)] = ideal_signals(twin.trajectory)
        key = (id(twin), name, id(log[name].time), lag)
        if key not in self._sampled:
            self._sampled[key] = sample(self._dense[id(twin)][name], log[name].time - self.start(index) - lag)
            self._kept.append(log)  # so that ids stay theirs
        return self._sampled[key]

    def finding(
        self,
        kind: str,
        index: int,
        channel: str,
        evidence: str,
        action: Action,
        used: bool,
        span: tuple[float, float] | None = None,
        repair: Repair | None = None,
    ) -> DataFinding:
        """A finding on a recording; `span` in stamps, the whole recording if left out."""
        log, start = self.recordings[index], self.start(index)
        if span is None:
            named = [s for name, s in log.signals.items() if channel and channel.startswith(name)]
            times = [s.time for s in named or log.signals.values()]
            span = (min(t[0] for t in times), max(t[-1] for t in times)) if times else (start, start)
        begin, end = (round(float(t - start), 6) for t in span)
        return DataFinding(self.names[index], channel, kind, begin, end, evidence, action, used, repair)


def sensor_of(name: str) -> str:
    """The sensor that a signal comes from: accelerometer and gyroscope of a link are one, and so are their stamps."""
    return name.rpartition("/")[0] if name.startswith(("imu/", "joint_command/")) else name


def spans(bad: Array) -> Iterator[tuple[int, int]]:
    """Stretches [start, stop) where `bad` (n,) is."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], bad, [False]]).astype(np.int8)))
    yield from ((int(a), int(b)) for a, b in edges.reshape(-1, 2))
