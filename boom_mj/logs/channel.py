"""What every log is made of, whatever its format: channels, and their messages in batches."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

Array = np.ndarray


@dataclass(frozen=True)
class Channel:
    """One publisher's messages on one topic.

    Attributes:
        id: number in the log; two publishers on a topic are two channels.
        topic: such as "/joint_states".
        type: name of the message type, such as "sensor_msgs/msg/JointState".
        encoding: of the messages: cdr, ros1, json, protobuf or row.
        schema_encoding: of the type's definition: ros2msg, ros2idl, protobuf, ...; "" without one.
        schema: the definition.
    """

    id: int
    topic: str
    type: str
    encoding: str
    schema_encoding: str = ""
    schema: bytes = b""


@dataclass(frozen=True, eq=False)
class Batch:
    """Messages of one channel in the order of the log.

    Attributes:
        log_time: when they were recorded, (n,), ns.
        messages: sequence of n, still encoded: bytes, or the rows of a table.
    """

    channel: Channel
    log_time: Array
    messages: Any


@dataclass(frozen=True)
class Labels:
    """A metadata record of a log."""

    name: str
    values: Mapping[str, str]


Wanted = Callable[[str], bool]
"""Whether the messages of a topic are to be read."""


@dataclass(frozen=True)
class Format:
    """One kind of log file.

    Attributes:
        name: as a user calls it.
        recognises: (path, its first bytes) -> whether a file is one.
        read: (path, wanted) -> batches and metadata; a channel is first announced by a batch without messages.
            Raises LogError on damage, warns with LogWarning of what is lost.
    """

    name: str
    recognises: Callable[[Path, bytes], bool]
    read: Callable[[Path, Wanted], Iterator[Batch | Labels]]


@dataclass(frozen=True, eq=False)
class Column:
    """One field of messages that are laid out alike.

    Attributes:
        names: of the numbers in the field, k; joint names, x y z, or 0 1 2.
        values: (m, k); (m, 0) where the messages leave the field empty.
    """

    names: tuple[str, ...]
    values: Array


@dataclass(frozen=True, eq=False)
class Group:
    """Messages of a batch that are laid out alike, decoded.

    Attributes:
        which: their places in the batch, (m,).
        stamp: of their headers, (m,), ns; None without one.
        frame_id: of their headers; "" without one.
        columns: field -> numbers.
    """

    which: Array
    stamp: Array | None
    frame_id: str
    columns: Mapping[str, Column]


class DecodingError(ValueError):
    """Message number `index` of a batch is not what its type says."""

    def __init__(self, index: int, reason: object) -> None:
        super().__init__(str(reason))
        self.index = index
