"""What is in a log: topics, types, rates, jitter, gaps, repetitions, clock resets, names, ranges."""

import re
import warnings
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from boom_mj.errors import LogError, LogWarning
from boom_mj.logs.channel import Array, Batch, Channel, Group
from boom_mj.logs.checks import HOLE
from boom_mj.logs.encodings import Decoder, decoder_of
from boom_mj.logs.encodings.row import ALL
from boom_mj.logs.fields import numeric_fields, select
from boom_mj.logs.formats import format_of, log_file
from boom_mj.logs.order import LATE
from boom_mj.logs.topics import METADATA

TIME = re.compile(r"^_*(time|t|timestamp|stamp|zeit|sec|seconds)(_?(s|ms|us|ns))?$", re.I)
MOST_NUMBERS = 64  # in a field; more are pictures and clouds
LARGEST = 2**16  # bytes of a message that is looked into


@dataclass(frozen=True)
class Times:
    """How the times of a topic run; all in s, but jitter_ms.

    Attributes:
        start, stop: first and last time.
        rate_hz: of the usual step; 0 with less than two messages.
        jitter_ms: 95 % of the steps are this close to the usual one.
        gaps, longest_gap, longest_gap_at: steps beyond five usual ones, the longest and when it begins.
        repeated: messages with the time of the one before.
        late: messages that come after younger ones, up to 0.1 s.
        resets, first_reset: larger jumps back, and the time before the first.
    """

    start: float
    stop: float
    rate_hz: float
    jitter_ms: float
    gaps: int
    longest_gap: float
    longest_gap_at: float
    repeated: int
    late: int
    resets: int
    first_reset: float | None


@dataclass(frozen=True)
class Range:
    """Numbers of one name in a field: extremes (NaN left aside), how many are NaN, largest magnitude."""

    least: float
    most: float
    missing: int

    @property
    def largest(self) -> float:
        return max(abs(self.least), abs(self.most)) if np.isfinite(self.least) else 0.0


@dataclass(frozen=True)
class Topic:
    """What one publisher sends on one topic.

    Attributes:
        channel: who sends what.
        count: number of messages.
        log: times of recording; None without messages.
        header: times of the message headers; None without.
        own: times by the fields that hold them (columns of a table), in the unit of the field.
        frames: frame_ids.
        fields: path -> name of the number -> range.
        problem: why the messages cannot be read, if so.
    """

    channel: Channel
    count: int
    log: Times | None
    header: Times | None
    own: Mapping[str, Times]
    frames: tuple[str, ...]
    fields: Mapping[str, Mapping[str, Range]]
    problem: str

    @property
    def time_base(self) -> str:
        """The sounder of both times: "header" or "log"."""
        if self.header is None or not self.header.stop:
            return "log"
        return "log" if self.header.resets and self.log and not self.log.resets else "header"


@dataclass(frozen=True)
class LogSummary:
    """A log at a glance; `remarks` are what reading it warned of."""

    path: Path
    format: str
    labels: Mapping[str, str]
    topics: tuple[Topic, ...]
    remarks: tuple[str, ...]


def inspect_log(path: str | Path) -> LogSummary:
    """Go through a log once.

    Raises:
        LogError: a file that is missing, damaged or of no known format.
    """
    path = log_file(Path(path))
    kind = format_of(path)
    tallies: dict[int, _Tally] = {}
    labels: dict[str, str] = {}
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", LogWarning)
        try:
            for item in kind.read(path, lambda topic: True):
                if isinstance(item, Batch):
                    tallies.setdefault(item.channel.id, _Tally(item.channel)).take(item)
                elif item.name == METADATA:
                    labels = dict(item.values)
        except OSError as error:
            raise LogError(f"{path} cannot be read: {error.strerror or error}") from error
    remarks = tuple(str(w.message) for w in caught)
    topics = sorted((tally.topic() for tally in tallies.values()), key=lambda t: (t.channel.topic, t.channel.id))
    return LogSummary(path, kind.name, labels, tuple(topics), remarks)


def times(stamps: Array) -> Times:
    """How times in ns run, (n,) with n > 0."""
    step = np.diff(stamps)
    forward = step[step > 0]
    usual = float(np.median(forward)) if forward.size else 0.0
    gaps = np.flatnonzero(step > HOLE * usual)
    longest = int(gaps[np.argmax(step[gaps])]) if gaps.size else 0
    resets = np.flatnonzero(step < -LATE * 1e9)
    return Times(
        start=float(stamps.min() / 1e9),
        stop=float(stamps.max() / 1e9),
        rate_hz=1e9 / usual if usual else 0.0,
        jitter_ms=float(np.quantile(np.abs(forward - usual), 0.95) / 1e6) if forward.size else 0.0,
        gaps=int(gaps.size),
        longest_gap=float(step[longest] / 1e9) if gaps.size else 0.0,
        longest_gap_at=float(stamps[longest] / 1e9) if gaps.size else 0.0,
        repeated=int((step == 0).sum()),
        late=int((step < 0).sum() - resets.size),
        resets=int(resets.size),
        first_reset=float(stamps[resets[0]] / 1e9) if resets.size else None,
    )


@dataclass
class _Tally:
    """Counts what comes on one channel."""

    channel: Channel
    log: list[Array] = field(default_factory=list)
    header: list[Array] = field(default_factory=list)
    rows: list[Array] = field(default_factory=list)  # of a table
    frames: set[str] = field(default_factory=set)
    ranges: dict[str, dict[str, Range]] = field(default_factory=dict)
    decoder: Decoder | None = None
    problem: str = ""

    def take(self, batch: Batch) -> None:
        if not len(batch.messages):
            return
        self.log.append(batch.log_time)
        if self.problem or len(batch.messages[0]) > LARGEST:
            return
        try:
            if self.decoder is None:
                self.decoder = decoder_of(self.channel)
                tree = self.decoder.tree(batch.messages[0])
                self.ranges = {path: {} for path in numeric_fields(tree) if _is_small(tree, path)}
            stamps = np.full(len(batch.messages), -1, np.int64)
            for group in self.decoder.decode(batch.messages, tuple(self.ranges)):
                self._count(group)
                if group.stamp is not None:
                    stamps[group.which] = group.stamp
            if (stamps >= 0).all():
                self.header.append(stamps)
            if self.channel.encoding == "row":
                self.rows.append(batch.messages)
        except ValueError as error:
            t = batch.log_time[getattr(error, "index", 0)] / 1e9
            self.problem = f"the message recorded at {t:.3f} s cannot be read: {error}"

    def _count(self, group: Group) -> None:
        self.frames |= {group.frame_id} - {""}
        for path, column in group.columns.items():
            for name, values in zip(column.names, column.values.T):
                finite = values[np.isfinite(values)]
                least, most = (finite.min(), finite.max()) if finite.size else (np.inf, -np.inf)
                before = self.ranges[path].get(name, Range(np.inf, -np.inf, 0))
                self.ranges[path][name] = Range(
                    min(before.least, float(least)),
                    max(before.most, float(most)),
                    before.missing + int(values.size - finite.size),
                )

    def topic(self) -> Topic:
        log, header = (np.concatenate(parts) if parts else None for parts in (self.log, self.header))
        complete = header is not None and log is not None and header.size == log.size
        own: dict[str, Times] = {}
        if self.rows:
            rows = np.concatenate(self.rows)
            for i, name in enumerate(self.ranges.get(ALL, {})):  # not of thousands of columns
                if len(rows) > 1 and (np.diff(rows[:, i]) > 0).mean() > 0.9:
                    own[name] = times(np.round(rows[:, i] * 1e9))
            own = {name: run for name, run in own.items() if TIME.match(name)} or own
        return Topic(
            channel=self.channel,
            count=0 if log is None else log.size,
            log=None if log is None or self.rows else times(log),
            header=times(header) if complete and header is not None else None,
            own=own,
            frames=tuple(sorted(self.frames)),
            fields={path: ranges for path, ranges in self.ranges.items() if ranges},
            problem=self.problem,
        )


def _is_small(tree: Any, path: str) -> bool:
    try:
        leaves = select(tree, path).leaves
    except ValueError:
        return False
    return 0 < sum(getattr(leaf, "count", 1) for leaf in leaves) <= MOST_NUMBERS
