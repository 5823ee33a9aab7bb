"""What one entry of a topic map takes out of a log: its channels, in SI, with their times."""

from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from boom_mj.errors import LogError
from boom_mj.logs.channel import Array, Batch, Group
from boom_mj.logs.order import in_order
from boom_mj.logs.topic_map import HEADER, LOG, Entry
from boom_mj.logs.units import UNITS
from boom_mj.recording import QUANTITIES

NOT_MEASURED = -1.0  # first entry of a covariance, by the convention of sensor_msgs/Imu


@dataclass(frozen=True, eq=False)
class Part:
    """Some channels of a signal.

    Attributes:
        channels: k names; empty where their number is free.
        stamps: (n,), ns, increasing; empty for a constant.
        values: (n, k) in SI; (1, k) for a constant.
        origin: what it is called in messages.
    """

    channels: tuple[str, ...]
    stamps: Array
    values: Array
    origin: str


@dataclass(eq=False)
class _Pieces:
    """Pieces of the channels that come together."""

    stamps: list[Array] = field(default_factory=list)
    log_times: list[Array] = field(default_factory=list)
    values: list[Array] = field(default_factory=list)
    publishers: dict[int, tuple[int, int]] = field(default_factory=dict)  # first and last log time


class Intake:
    """Collects the numbers of one entry."""

    def __init__(self, entry: Entry) -> None:
        self.entry = entry
        self._pieces: dict[tuple[int, ...], _Pieces] = {}  # by the places in entry.names
        self._empty: float | None = None  # s, first message that names the channels but has no numbers
        self._others: tuple[str, ...] = ()  # names in a message without any of ours

    @property
    def fields(self) -> tuple[str, ...]:
        """Fields that it wants decoded."""
        entry = self.entry
        own_time = () if entry.time in (HEADER, LOG) else (entry.time,)
        return (entry.field, f"{entry.field}_covariance", *own_time)

    def take(self, batch: Batch, group: Group) -> None:
        """Add messages that are laid out alike.

        Raises:
            LogError: messages that are not what the entry says.
        """
        entry, column = self.entry, group.columns[self.entry.field]
        if entry.publisher not in (None, batch.channel.id):
            return
        stamps = self._stamps(batch, group)
        t = stamps[0] / 1e9
        if entry.frame and group.frame_id != entry.frame:
            raise LogError(f"frame_id is '{group.frame_id}'; must be '{entry.frame}' (at {t:.3f} s)")
        if entry.names:
            if double := [name for name in entry.names if column.names.count(name) > 1]:
                raise LogError(
                    f"{', '.join(double)} missing or double at {t:.3f} s; present are {', '.join(column.names)}"
                )
            here = tuple(i for i, name in enumerate(entry.names) if name in column.names)
        else:
            here = tuple(range(column.values.shape[1]))
            self._check_width(here, t)
        if not here:
            self._others = self._others or column.names
        if not column.values.shape[1]:
            self._empty = t if self._empty is None else min(t, self._empty)
            return
        if here:
            chosen = [column.names.index(entry.names[i]) for i in here] if entry.names else list(here)
            values = column.values[:, chosen]
            covariance = group.columns[f"{entry.field}_covariance"].values
            if covariance.size:
                values = np.where(covariance[:, :1] == NOT_MEASURED, np.nan, values)
            pieces = self._pieces.setdefault(here, _Pieces())
            log_times = batch.log_time[group.which]
            first, last = pieces.publishers.get(batch.channel.id, (log_times[0], log_times[-1]))
            pieces.publishers[batch.channel.id] = min(first, log_times.min()), max(last, log_times.max())
            pieces.stamps.append(stamps)
            pieces.log_times.append(log_times)
            pieces.values.append(values)

    def parts(self) -> list[Part]:
        """What came in, in SI; empty if the log has none of it.

        Raises:
            LogError: channels that are missing, in all or in some messages; a clock set back; rival publishers.
        """
        entry = self.entry
        if entry.constant:
            values = entry.factor * np.array([entry.constant])
            return [Part(entry.channels, np.empty(0, np.int64), values, "a constant")]
        covered = [i for here in self._pieces for i in here]
        if entry.names and self._pieces and (missing := set(range(len(entry.names))) - set(covered)):
            names = [entry.names[i] for i in sorted(missing)]
            there = [entry.names[i] for i in sorted(set(covered))] + list(self._others)
            raise LogError(f"{', '.join(names)} missing; present are {', '.join(there)}")
        if not self._pieces and self._others:
            raise LogError(f"{', '.join(entry.names)} missing; present are {', '.join(self._others)}")
        if self._pieces and self._empty is not None:
            width = max(map(len, self._pieces))
            raise LogError(f"{entry.field} changes from {width} to 0 values at {self._empty:.3f} s")
        if not entry.names and len(self._pieces) > 1:
            (_, before), (t, after), *_ = sorted((p.stamps[0][0] / 1e9, len(k)) for k, p in self._pieces.items())
            raise LogError(f"{entry.field} changes from {before} to {after} values at {t:.3f} s")
        if entry.names and len(covered) > len(set(covered)):
            rarest = min(self._pieces, key=lambda here: len(self._pieces[here].stamps))
            absent = [entry.names[i] for i in sorted(set(covered) - set(rarest))] or [entry.names[i] for i in rarest]
            t = self._pieces[rarest].stamps[0][0] / 1e9
            raise LogError(f"{', '.join(absent)} missing in some messages, the first at {t:.3f} s, but not in others")
        return [self._part(here, pieces) for here, pieces in self._pieces.items()]

    def _part(self, here: tuple[int, ...], pieces: _Pieces) -> Part:
        entry = self.entry
        spans = sorted((*span, number) for number, span in pieces.publishers.items())
        for (_, last, one), (first, _, other) in pairwise(spans):
            if first <= last:
                raise LogError(
                    f"two publishers ({one} and {other}) send the same channels; "
                    f"choose one with publisher = {one} in a topic map"
                )
        stamps, log_times, values = map(np.concatenate, (pieces.stamps, pieces.log_times, pieces.values))
        if (np.diff(log_times) < 0).any():
            order = np.argsort(log_times, kind="stable")
            stamps, values = stamps[order], values[order]
        stamps, values = in_order(stamps, values, entry.topic)
        sign, offset = (_per_channel(given, here, neutral) for given, neutral in ((entry.sign, 1), (entry.offset, 0)))
        channels = tuple(entry.channels[i] for i in here) if entry.channels else ()
        values = np.ascontiguousarray(entry.factor * (sign * values + offset))
        return Part(channels, stamps, values, f"{entry.topic} {entry.field}")

    def _check_width(self, here: tuple[int, ...], t: float) -> None:
        """All numbers of a field in order are as many as there are channels."""
        per = 3 if QUANTITIES[self.entry.signal].points else 1
        what = "poses" if per == 3 else "values"
        if here and self.entry.channels and len(here) != len(self.entry.channels):
            due = len(self.entry.channels) // per
            raise LogError(f"{len(here) // per} {what} instead of {due} at {t:.3f} s")

    def _stamps(self, batch: Batch, group: Group) -> Array:
        if self.entry.time == LOG:
            return np.asarray(batch.log_time[group.which], np.int64)
        if self.entry.time == HEADER:
            if group.stamp is None:
                raise LogError(
                    f'messages of {batch.channel.type} have no header stamp; say time = "log" or time = "FIELD"'
                )
            return group.stamp
        seconds = group.columns[self.entry.time].values
        if seconds.shape[1] != 1:
            raise LogError(f"the time field {self.entry.time} holds {seconds.shape[1]} numbers; must hold one")
        if not np.isfinite(seconds).all():
            raise LogError(f"the time field {self.entry.time} is not always a number")
        return np.round(seconds[:, 0] * UNITS["s"][self.entry.time_unit] * 1e9).astype(np.int64)


def _per_channel(given: tuple[float, ...], here: tuple[int, ...], neutral: float) -> Array:
    if len(given) <= 1:
        return np.full(len(here), given[0] if given else neutral, float)
    return np.array([given[i] for i in here], float)
