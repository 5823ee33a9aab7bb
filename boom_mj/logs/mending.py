"""Topic maps that mend what is wrong with a log: the map it was read with, and repairs of its signals on top.

Every channel is taken by itself - topic, field, name, sign, offset, unit -, repaired, and joined again with those of
its signal that still come from one place.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import groupby

from boom_mj.logs.topic_map import Entry, TopicMap, own_map
from boom_mj.logs.units import UNITS
from boom_mj.recording import QUANTITIES, Recording
from boom_mj.recording.names import AXES
from boom_mj.replay.quality import Repair

FREE = {"source": (), "to": (), "sign": (), "offset": (), "unit": "", "constant": ()}  # what channels have of their own


@dataclass(frozen=True)
class _Wire:
    """What feeds one channel."""

    entry: Entry
    channel: str
    name: str
    sign: int
    offset: float
    unit: str

    @property
    def factor(self) -> float:
        return UNITS[QUANTITIES[self.entry.signal].unit][self.unit]


def mended_map(log: Recording, repairs: Sequence[Repair], read_with: TopicMap | None = None) -> str:
    """Topic map, as TOML, by which a log reads as the repairs say.

    Args:
        log: as it was read; signals that it lacks are left out of the map.
        read_with: map that it was read with; the one of our own logs if left out.
    """
    wires: dict[str, dict[str, _Wire]] = {}
    for entry in (read_with or own_map()).entries:
        if entry.signal in log:
            wires.setdefault(entry.signal, {}).update({wire.channel: wire for wire in _wires(entry)})
    for places, group in groupby(repairs, key=lambda repair: bool(repair.source)):
        before = {signal: dict(found) for signal, found in wires.items()}
        for repair in group:
            _mend(wires, before if places else wires, repair)
    return "\n".join(line for found in wires.values() for line in _entries(list(found.values())))


def _wires(entry: Entry) -> Iterator[_Wire]:
    channels = entry.channels or QUANTITIES[entry.signal].channels
    points = QUANTITIES[entry.signal].points
    for k, channel in enumerate(channels):
        point = f"{k // len(AXES)}/{AXES[k % len(AXES)]}"
        name = entry.source[k] if entry.source else point if points else channel
        sign, offset = (float(given[k % len(given)]) if given else 0.0 for given in (entry.sign, entry.offset))
        yield _Wire(entry, channel, name, int(sign) or 1, offset, entry.unit)


def _mend(wires: dict[str, dict[str, _Wire]], before: dict[str, dict[str, _Wire]], repair: Repair) -> None:
    if repair.source and not repair.channel:  # a whole sensor
        for signal in [name for name in wires if name.startswith(f"{repair.signal}/")]:
            other = before[f"{repair.source}/{signal.rpartition('/')[2]}"]
            here = {"signal": signal}
            wires[signal] = {c: replace(wire, entry=wire.entry.model_copy(update=here)) for c, wire in other.items()}
        return
    found = wires.get(repair.signal, {})
    chosen = [c for c in found if not repair.channel or c == repair.channel or c.startswith(f"{repair.channel}/")]
    for channel in chosen:
        wire = found[channel]
        if repair.source:
            axis = channel[len(repair.channel) :]
            wire = replace(before[repair.signal][f"{repair.source}{axis}"], channel=channel)
        if repair.unit:
            wire = replace(wire, unit=repair.unit)
        if repair.sign < 0:
            wire = replace(wire, sign=-wire.sign, offset=-wire.offset)
        found[channel] = replace(wire, offset=wire.offset + repair.offset / wire.factor)


def _entries(wires: list[_Wire]) -> Iterator[str]:
    """Entries of one signal."""
    for (entry, unit), group in groupby(wires, key=lambda wire: (wire.entry.model_copy(update=FREE), wire.unit)):
        part = list(group)
        keys = {
            "signal": entry.signal,
            "role": entry.role,
            "topic": entry.topic,
            "field": entry.field,
            "from": [wire.name for wire in part],
            "to": [wire.channel for wire in part],
            "sign": [wire.sign for wire in part],
            "offset": [round(wire.offset, 9) for wire in part],
            "unit": unit,
            "time": entry.time,
            "time_unit": entry.time_unit,
            "publisher": entry.publisher,
            "type": entry.type,
            "frame": entry.frame,
        }
        if not entry.topic:
            constants = [wire.entry.constant[wire.entry.channels.index(wire.channel)] for wire in part]
            keys = {"signal": entry.signal, "to": keys["to"], "constant": constants, "unit": unit}
        yield "[[entry]]"
        yield from (f"{key} = {_toml(value)}" for key, value in keys.items() if value not in ("", None))
        yield ""


def _toml(value: object) -> str:
    if isinstance(value, list):
        return f"[{', '.join(map(_toml, value))}]"
    if isinstance(value, str):
        return '"' + value.replace("\\", "\\\\").replace('"', '\\"') + '"'
    return repr(value)
