"""CDR, the encoding of ROS 2, and that of ROS 1: messages that are laid out alike are decoded all at once.

The first message is walked along its type's definition: this gives the place of every number, and the bytes that
decide on the places (lengths and texts). Messages of the same size with the same deciding bytes have the same places.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from rosbags.interfaces import Nodetype
from rosbags.typesys import get_types_from_idl, get_types_from_msg

from boom_mj.logs.channel import Array, Channel, Column, DecodingError, Group
from boom_mj.logs.fields import Leaf, frame_of, select, stamp_leaves
from boom_mj.logs.messages import typestore

IDL_SEPARATOR = "=" * 80 + "\n"
DTYPES = {
    "bool": "u1", "byte": "u1", "char": "u1", "octet": "u1", "int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2",
    "int32": "i4", "uint32": "u4", "int64": "i8", "uint64": "u8", "float32": "f4", "float64": "f8",
}  # fmt: skip
LAYOUTS_KEPT = 64
TIMES = ("builtin_interfaces/msg/Time", "builtin_interfaces/msg/Duration")  # ROS 1 does not define them in logs
Definitions = Mapping[str, Any]


@dataclass(frozen=True)
class Rules:
    """How an encoding differs.

    Attributes:
        prefix: bytes in front, from behind which places count.
        aligned: whether numbers stand at multiples of their size.
        terminated: whether texts end with a zero.
        padding: bytes that may follow.
    """

    prefix: int
    aligned: bool
    terminated: bool
    padding: int


CDR = Rules(prefix=4, aligned=True, terminated=True, padding=3)
ROS1 = Rules(prefix=0, aligned=False, terminated=False, padding=0)


def definitions_of(channel: Channel) -> Definitions:
    """Fields by type name, from the definition in the log; those of ROS 2 Humble where the log has none.

    Raises:
        ValueError: a definition that cannot be read.
    """
    text = channel.schema.decode()
    if not text.strip():
        found: Definitions = typestore().fielddefs
    elif channel.schema_encoding in ("ros2idl", "omgidl"):
        parts = text.split(IDL_SEPARATOR)[1:] if text.startswith(f"{IDL_SEPARATOR}IDL: ") else ["\n" + text]
        found = {name: fields for part in parts for name, fields in get_types_from_idl(part.split("\n", 1)[1]).items()}
    else:
        found = get_types_from_msg(text, type_name(channel.type))
    return {name: typestore().fielddefs[name] for name in TIMES} | dict(found)


def type_name(name: str) -> str:
    """Name of a type as ROS 2 says it: sensor_msgs/Imu and sensor_msgs::msg::Imu are sensor_msgs/msg/Imu."""
    parts = name.replace("::", "/").split("/")
    return "/".join((parts[0], "msg", parts[-1]))


@dataclass(frozen=True, eq=False)
class Layout:
    """Where everything stands in messages of one size.

    Attributes:
        tree: the message with a `Leaf` for every number.
        deciding: places of the bytes that decide on the others, (d,).
        key: those bytes, (d,).
        gathers: by field, what `_gather` found.
    """

    tree: Any
    deciding: Array
    key: Array
    gathers: dict[str, Any] = field(default_factory=dict)


class CdrDecoder:
    """Messages of one channel -> groups; a field is an empty column where messages lack it."""

    def __init__(self, channel: Channel, rules: Rules = CDR) -> None:
        self._type, self._rules = type_name(channel.type), rules
        self._definitions = definitions_of(channel)
        self._layouts: dict[int, list[Layout]] = {}  # by size

    def decode(self, messages: Sequence[bytes], fields: Sequence[str]) -> Iterator[Group]:
        sizes = np.fromiter(map(len, messages), np.int64, len(messages))
        for size in np.unique(sizes):
            left = np.flatnonzero(sizes == size)
            rows = np.frombuffer(b"".join(messages[int(i)] for i in left), np.uint8).reshape(left.size, size)
            known = self._layouts.setdefault(int(size), [])
            for layout in tuple(known):
                left, rows, group = _split(layout, left, rows, fields)
                if group:
                    yield group
            while left.size:
                try:
                    layout = self._walk(rows[0])
                except Exception as error:  # whatever broken bytes lead to
                    raise DecodingError(int(left[0]), error) from error
                known.append(layout)
                del known[:-LAYOUTS_KEPT]
                left, rows, group = _split(layout, left, rows, fields)
                if group:
                    yield group

    def tree(self, message: bytes) -> Any:
        """A message with a `Leaf` for every number."""
        try:
            return self._walk(np.frombuffer(message, np.uint8)).tree
        except Exception as error:  # whatever broken bytes lead to
            raise DecodingError(0, error) from error

    def _walk(self, row: Array) -> Layout:
        walk = _Walk(row.tobytes(), self._definitions, self._rules)
        tree = walk.struct(self._type)
        walk.finish()
        deciding = np.concatenate([np.arange(self._rules.prefix), *(np.arange(*span) for span in walk.deciding)])
        return Layout(tree, deciding, row[deciding])


def _split(layout: Layout, left: Array, rows: Array, fields: Sequence[str]) -> tuple[Array, Array, Group | None]:
    """What remains of the messages, and the group of those with this layout."""
    alike = (rows[:, layout.deciding] == layout.key).all(axis=1)
    if not alike.any():
        return left, rows, None
    whole = bool(alike.all())
    mine = rows if whole else rows[alike]
    which = left if whole else left[alike]
    try:
        columns = {path: Column(*_gather(layout, mine, path)) for path in fields}
    except ValueError as error:
        raise DecodingError(int(which[0]), error) from error
    group = Group(which, _stamps(layout, mine), frame_of(layout.tree), columns)
    return (left[:0], rows[:0], group) if whole else (left[~alike], rows[~alike], group)


def _gather(layout: Layout, rows: Array, path: str) -> tuple[tuple[str, ...], Array]:
    """Names and numbers of a field, (m, k)."""
    if path not in layout.gathers:
        selection = select(layout.tree, path)
        places = [  # runs of one type: the bytes of all their numbers
            (dtype, np.concatenate([np.arange(o, o + np.dtype(dtype).itemsize * c) for o, c in run]))
            for dtype, run in _runs(selection.leaves)
        ]
        layout.gathers[path] = selection.names, places
    names, places = layout.gathers[path]
    parts = [np.ascontiguousarray(rows[:, where]).view(dtype).astype(np.float64) for dtype, where in places]
    return names, np.concatenate(parts, axis=1) if parts else np.empty((len(rows), 0))


def _runs(leaves: Sequence[Leaf]) -> list[tuple[str, list[tuple[int, int]]]]:
    runs: list[tuple[str, list[tuple[int, int]]]] = []
    for leaf in leaves:
        if not runs or runs[-1][0] != leaf.dtype:
            runs.append((leaf.dtype, []))
        runs[-1][1].append((leaf.offset, leaf.count))
    return runs


def _stamps(layout: Layout, rows: Array) -> Array | None:
    leaves = stamp_leaves(layout.tree)
    if leaves is None:
        return None
    sec, nsec = (
        np.ascontiguousarray(rows[:, leaf.offset : leaf.offset + 4]).view(leaf.dtype)[:, 0].astype(np.int64)
        for leaf in leaves
    )
    return np.asarray(sec * 10**9 + nsec)


class _Walk:
    """Goes through one message along its definition and notes where what stands."""

    def __init__(self, data: bytes, definitions: Definitions, rules: Rules) -> None:
        front = data[: rules.prefix]
        if rules.prefix and front[:2] not in (b"\0\0", b"\0\1"):
            raise ValueError(f"encapsulation {front.hex() or 'missing'} is not plain CDR")
        self.data, self.definitions, self.rules, self.at = data, definitions, rules, rules.prefix
        self.order = ">" if front[:2] == b"\0\0" else "<"
        self.deciding: list[tuple[int, int]] = []

    def finish(self) -> None:
        if not self.at <= len(self.data) <= self.at + self.rules.padding:
            raise ValueError(f"{len(self.data)} bytes instead of {self.at}")

    def struct(self, name: str) -> dict[str, Any]:
        if name not in self.definitions:
            raise ValueError(f"the type {name} is not defined")
        return {key: self.value(description) for key, description in self.definitions[name][1]}

    def value(self, description: Any) -> Any:
        kind, detail = description
        if kind == Nodetype.NAME:
            return self.struct(detail)
        if kind == Nodetype.BASE:
            return self.text() if detail[0] == "string" else self.numbers(detail[0], 1)
        element, count = detail[0], self.length() if kind == Nodetype.SEQUENCE else detail[1]
        if count > len(self.data):
            raise ValueError(f"{count} elements in {len(self.data)} bytes")
        if element[0] == Nodetype.BASE and element[1][0] != "string":
            return [self.numbers(element[1][0], count)] if count else []
        return [self.value(element) for _ in range(count)]

    def numbers(self, kind: str, count: int) -> Leaf:
        if kind not in DTYPES:
            raise ValueError(f"numbers of type {kind} are not supported")
        dtype = np.dtype(self.order + DTYPES[kind])
        at = self.take(dtype.itemsize, dtype.itemsize * count)
        return Leaf(at, dtype.str, count)

    def length(self) -> int:
        at = self.take(4, 4)
        self.deciding.append((at, at + 4))
        return int.from_bytes(self.data[at : at + 4], "little" if self.order == "<" else "big")

    def text(self) -> str:
        size = self.length()
        at = self.take(1, size)
        end = at + size - self.rules.terminated
        if self.rules.terminated and (not size or self.data[end]):
            raise ValueError(f"a text of {size} bytes without its end at byte {at}")
        self.deciding.append((at, at + size))
        return self.data[at:end].decode()

    def take(self, align: int, size: int) -> int:
        at = self.at + ((self.rules.prefix - self.at) % align if self.rules.aligned else 0)
        if at + size > len(self.data):
            raise ValueError(f"it ends at byte {len(self.data)} where {size} more are due at byte {at}")
        self.at = at + size
        return at
