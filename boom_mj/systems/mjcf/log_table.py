"""A log through a channel map: in the order of its stamps, without what its samples alone show to be wrong.

No check here knows the machine. What looks odd by itself may be how a machine is - a joint that rests reads the same
again and again, one that stops reads its end - so that only three things count as wrong: samples that are not there, a
stretch without any of what the model follows, and glitches, as no machine can jump away and back between two samples.
"""

import warnings
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from boom_mj.errors import ChannelMapError, LogError, LogWarning
from boom_mj.estimation.blocks import own_noise
from boom_mj.files import inside
from boom_mj.logs.columns import read_columns
from boom_mj.logs.order import put_in_place
from boom_mj.replay.quality import Action, DataFinding
from boom_mj.replay.quality.channels import resolution
from boom_mj.systems.mjcf.channel_map import ChannelEntry, ChannelMap

Array = np.ndarray
Span = tuple[float, float]
MOST_AGAIN = 0.5  # of the times, that may have rows that differ: beyond it the clock is coarser than what it stamps
HOLE = 5.0  # usual steps between samples: what is bridged is no longer
EVEN = 1.5  # usual steps, up to which no sample is missing between two
LONGEST = 2  # samples of a glitch
BESIDE = 2  # samples on either side that a glitch is held against
SIGMAS = 8.0  # times the noise or a step of it, by which it lies beyond them: noise alone does so once in 1e15 samples
RANGES = 3.0  # times their own range, by which it does: a motion that is sampled well bends less
ADVICE = "name another field as time in the map"
INERT = "position", "velocity"  # they cannot jump; a force or an acceleration may, once a blow


@dataclass(frozen=True, eq=False)
class LogTable:
    """The channels of a log.

    Attributes:
        path: of the log.
        channels: its map.
        time: (n,), s, increasing.
        values: by channel, SI, (n,); NaN where there is no sound sample.
        holes: by channel, where it says nothing for longer than is bridged, s.
        let_go: the field that tells a release, (n,); of a map that names one.
        findings: what is wrong, and what was done about it.
    """

    path: Path
    channels: ChannelMap
    time: Array
    values: Mapping[str, Array]
    holes: Mapping[str, tuple[Span, ...]]
    let_go: Array | None
    findings: tuple[DataFinding, ...]

    @property
    def gaps(self) -> list[Span]:
        """Where something is missing that the model follows, or begins with, in order."""
        return sorted(hole for entry in self.channels.channel if follows(entry) for hole in self.holes[entry.name])

    def bridged(self, entry: ChannelEntry, values: Array) -> Array:
        """Values of a channel (n,) without holes: commands hold, all else goes on evenly."""
        known = np.isfinite(values)
        if known.all():
            return values
        if entry.role == "control":
            latest = np.maximum.accumulate(np.where(known, np.arange(len(values)), np.argmax(known)))
            return values[latest]
        return np.interp(self.time, self.time[known], values[known])


def read_table(path: Path, channels: ChannelMap) -> LogTable:
    """Read a log and look through it; channels that have a clock of their own say nothing at the times of others.

    Raises:
        LogError: fields that are not there or not of one length, stamps that make no order, a channel without samples.
    """
    fields, clocks = _fields(path, channels), {entry.name: channels.clock(entry) for entry in channels.channel}
    asked: dict[str, set[str]] = {channels.time: {channels.release.field} if channels.release else set()}
    for entry in channels.channel:
        asked.setdefault(clocks[entry.name], set()).update(entry.fields)
    rows = {
        clock: _sorted(path, fields[clock] * channels.time_scale, {name: fields[name] for name in names})
        for clock, names in asked.items()
        if names
    }
    time = np.unique(np.concatenate([stamps for stamps, _ in rows.values()]))
    values: dict[str, Array] = {}
    holes: dict[str, tuple[Span, ...]] = {}
    findings: list[DataFinding] = []
    for entry in channels.channel:
        stamps, columns = rows[clocks[entry.name]]
        own = _value(entry, columns)
        if not np.isfinite(own).any():
            raise LogError(f"{path}: {entry.name} has no value at all")
        away = _jumps(entry, own) if entry.sensed else np.zeros(len(own), bool)
        values[entry.name] = np.full(len(time), np.nan)
        values[entry.name][np.searchsorted(time, stamps)] = np.where(away, np.nan, own)
        known = np.isfinite(values[entry.name])
        holes[entry.name] = () if entry.role == "temperature" else tuple(_holes(time, known, 0.5 / channels.cutoff))
        findings += _findings(path, entry, stamps, own, away, holes[entry.name], float(time[0]))
    let_go = None
    if channels.release:
        stamps, columns = rows[channels.time]
        known = np.isfinite(columns[channels.release.field])
        let_go = np.interp(time, stamps[known], columns[channels.release.field][known])
    return LogTable(path, channels, time, values, holes, let_go, tuple(findings))


def follows(entry: ChannelEntry) -> bool:
    """Whether the model follows a channel, or begins with it: it needs all of it."""
    return entry.role in ("drive", "control") or (entry.sensed and bool(entry.joint) and entry.what == "position")


def within(time: Array, spans: Iterable[Span], margin: float = 0.0) -> Array:
    """Which moments lie in a span or within `margin` (s) of it, (n,) of bool."""
    found = np.zeros(len(time), bool)
    for begin, end in spans:
        found |= (time > begin - margin) & (time < end + margin)
    return found


def glitches(values: Array, noise: float) -> Array:
    """Up to LONGEST samples in a row that lie far beyond all of the BESIDE ones before and after, (n,) of bool.

    Args:
        values: (n,), NaN where there is none.
        noise: standard deviation, or the step in which values come.
    """
    known = np.flatnonzero(np.isfinite(values))
    found = np.zeros(len(values), bool)
    for length in range(1, min(LONGEST, len(known) - 2 * BESIDE) + 1):
        windows = sliding_window_view(values[known], length + 2 * BESIDE)
        around = np.delete(windows, np.s_[BESIDE:-BESIDE], axis=1)
        low, high, row = around.min(axis=1), around.max(axis=1), windows[:, BESIDE:-BESIDE]
        beyond = np.maximum(row - high[:, None], low[:, None] - row).min(axis=1)
        starts = np.flatnonzero(beyond > np.maximum(SIGMAS * noise, RANGES * (high - low)))
        found[known[starts[:, None] + BESIDE + np.arange(length)]] = True
    return found


def _fields(path: Path, channels: ChannelMap) -> dict[str, Array]:
    """All fields that a map names; `FILE:field` stands in a file beside the log."""
    release = {channels.release.field} if channels.release else set()
    clocks = {channels.clock(entry) for entry in channels.channel}
    fields = {channels.time, *release, *clocks, *(f for entry in channels.channel for f in entry.fields)}
    found: dict[str, Array] = {}
    for beside in {field.rpartition(":")[0] for field in fields}:
        mine = {field: field.rpartition(":")[2] for field in fields if field.rpartition(":")[0] == beside}
        columns = read_columns(inside(path.parent, beside, ChannelMapError, path) if beside else path, mine.values())
        found |= {field: columns[name] for field, name in mine.items()}
    return found


def _sorted(path: Path, time: Array, fields: Mapping[str, Array]) -> tuple[Array, Mapping[str, Array]]:
    """Rows that have a stamp, in its order; those of one stamp as their mean."""
    for name, column in fields.items():
        if len(column) != len(time):
            raise LogError(f"{path}: {name} has {len(column)} samples, its time {len(time)}")
    stamped = np.isfinite(1e9 * time)
    if stamped.sum() < 10:
        raise LogError(f"{path}: the time has {len(time)} samples, of which {int((~stamped).sum())} are empty")
    if not stamped.all():
        warnings.warn(f"{path}: {int((~stamped).sum())} rows without a time are left out", LogWarning, stacklevel=3)
    time, fields = time[stamped], {name: column[stamped] for name, column in fields.items()}
    if (np.diff(time) > 0).all():
        return time, fields
    try:
        stamps, rows = put_in_place(1e9 * time, np.stack(list(fields.values()), axis=1), str(path), ADVICE)
    except LogError as error:
        raise LogError(f"{path}: {error}") from error
    stamps, starts = np.unique(stamps, return_index=True)
    least, most = (of.reduceat(rows, starts, axis=0) for of in (np.fmin, np.fmax))
    if differ := int((least < most).any(axis=1).sum()):
        said = f"{path}: {differ} of {len(stamps)} times have several rows that differ"
        if differ > MOST_AGAIN * len(stamps):
            raise LogError(f"{said}: times must increase")
        warnings.warn(f"{said}; their mean counts", LogWarning, stacklevel=3)
    known = np.isfinite(rows)
    count, total = (np.add.reduceat(of, starts, axis=0) for of in (known, np.where(known, rows, 0.0)))
    return stamps / 1e9, dict(zip(fields, np.where(count > 0, total / np.maximum(count, 1), np.nan).T))


def _value(entry: ChannelEntry, fields: Mapping[str, Array]) -> Array:
    terms = {entry.field: 1.0} if entry.field else entry.terms
    logged = np.array(sum(factor * fields[field] for field, factor in terms.items()))
    if entry.wrap is not None:
        known = np.isfinite(logged)
        logged[known] = np.unwrap(logged[known], period=entry.wrap)
    if entry.limit is not None:
        logged = np.clip(logged, -entry.limit, entry.limit)
    return entry.scale * logged + entry.offset


def _jumps(entry: ChannelEntry, values: Array) -> Array:
    """Glitches; of what may jump only those as far beyond all the rest as that is wide."""
    found = glitches(values, max(entry.noise, own_noise(values), resolution(values)))
    if entry.what in INERT or not found.any():
        return found
    rest = values[~found & np.isfinite(values)]
    middle, reach = (rest.max() + rest.min()) / 2, 1.5 * np.ptp(rest)
    return found & (np.abs(values - middle) > reach)


def _holes(time: Array, known: Array, cutoff: float) -> Iterator[Span]:
    """Where samples are farther apart than HOLE usual steps and than a filter would bridge, the log's ends included."""
    at = time[known]
    longest = max(HOLE * float(np.median(np.diff(at))) if len(at) > 1 else 0.0, cutoff)
    edges = np.concatenate([time[:1], at, time[-1:]])
    for k in np.flatnonzero(np.diff(edges) > longest):
        yield float(edges[k]), float(edges[k + 1])


def _findings(
    path: Path, entry: ChannelEntry, time: Array, own: Array, away: Array, holes: Sequence[Span], start: float
) -> Iterator[DataFinding]:
    """Of a channel at its times (n,) with its glitches and holes; in answers time counts from the log's start."""
    missing = ~np.isfinite(own) & ~within(time, holes)
    steps = np.diff(time[np.isfinite(own)])
    sparse = not len(steps) or (steps < EVEN * np.median(steps)).all()  # none is missing: it comes at a rate of its own

    def said(kind: str, span: Span, text: str, action: Action) -> DataFinding:
        begin, end = (float(moment) - start for moment in span)
        return DataFinding(str(path), entry.name, kind, begin, end, text, action, used=True)

    def few(bad: Array) -> tuple[Span, str]:
        return (time[bad][0], time[bad][-1]), f"in {int(bad.sum())} of {len(own)} samples"

    if missing.any() and not sparse:
        span, where = few(missing)
        done = Action.LEFT_OUT if entry.role == "compare" else Action.REPAIRED
        yield said("dropped", span, f"has no value {where}", done)
    for begin, end in holes:
        text = f"has no value from {begin - start:.2f} to {end - start:.2f} s"
        yield said("dropped", (begin, end), text + ", which moves the model" * follows(entry), Action.LEFT_OUT)
    if away.any():
        span, where = few(away)
        far = np.abs(own[away] - np.nanmedian(own)).max()
        text = f"jumps away and back {where}, up to {far:.4g} {entry.unit or '1'}"
        yield said("spiky", span, text, Action.CENSORED if entry.role == "compare" else Action.REPAIRED)
