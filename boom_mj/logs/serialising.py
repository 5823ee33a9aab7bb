"""Messages that differ in their stamps and numbers only, serialised at once.

One message is packed and serialised with a mark for every number; where a mark stands in its bytes, that number stands
in the bytes of all. Marks are numbers that no message holds otherwise.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

from boom_mj.logs.container import HEAD, HEAD_SIZE, PREFIX, Opcode
from boom_mj.logs.messages import make, typestore

Array = np.ndarray
Pack = Callable[[Any, Array], Any]  # (stamp, numbers (k,)) -> message

SECOND = 10**9  # ns
STAMP = (0x5EA15EA1, 0x2A511CED)  # s and ns of the marked message
MARKS = 0x7FD5A5A500000000  # bits of the first mark, a finite double
ENCAPSULATION = 4  # bytes in front of CDR, from behind which numbers stand at multiples of their size


def serialise(message: Any) -> bytes:
    """One message in CDR."""
    return bytes(typestore().serialize_cdr(message, message.__msgtype__))


def stamp_of(nanoseconds: int) -> Any:
    """A time as ROS 2 says it."""
    return make("builtin_interfaces/msg/Time", *divmod(nanoseconds, SECOND))


class Serialiser:
    """Makes the records of a channel's messages, head and CDR, from their stamps and numbers."""

    def __init__(self, pack: Pack, width: int) -> None:
        """Lay out messages of `width` numbers."""
        marks = MARKS + np.arange(width, dtype="<u8")
        data = serialise(pack(make("builtin_interfaces/msg/Time", *STAMP), marks.view("<f8")))
        whole = data[ENCAPSULATION:]
        doubles = np.frombuffer(whole[: len(whole) // 8 * 8], "<u8") - np.uint64(MARKS)
        pairs = np.frombuffer(whole[: len(whole) // 4 * 4], "<u4")
        start = HEAD_SIZE + ENCAPSULATION
        fields = [*HEAD]
        offsets = np.cumsum([0, *(np.dtype(kind).itemsize for _, kind in HEAD)])[:-1].tolist()
        self._numbers = []
        for place in np.flatnonzero(doubles < width).tolist():
            self._numbers.append((f"number{place}", int(doubles[place])))
            fields.append((f"number{place}", "<f8"))
            offsets.append(start + 8 * place)
        self._stamps = []
        for place in np.flatnonzero((pairs[:-1] == STAMP[0]) & (pairs[1:] == STAMP[1])).tolist():
            self._stamps.append(f"stamp{place}")
            fields.append((f"stamp{place}", "(2,)<u4"))
            offsets.append(start + 4 * place)
        names, formats = zip(*fields)
        self.size = HEAD_SIZE + len(data)
        self._type = np.dtype({"names": names, "formats": formats, "offsets": offsets, "itemsize": self.size})
        self._template = np.frombuffer(bytes(HEAD_SIZE) + data, f"V{self.size}")

    def records(self, channel: int, stamps: Array, numbers: Array, first: int = 0) -> list[bytes]:
        """Messages with their heads.

        Args:
            channel: number of the channel.
            stamps: (n,), ns.
            numbers: (n, width).
            first: sequence number of the first.
        """
        whole = np.repeat(self._template, len(stamps))
        found = whole.view(self._type)
        found["opcode"], found["length"], found["channel"] = Opcode.MESSAGE, self.size - PREFIX, channel
        found["sequence"] = np.arange(first, first + len(stamps))
        found["log_time"] = found["publish_time"] = stamps
        split = np.stack(np.divmod(stamps, SECOND), axis=1)
        for name in self._stamps:
            found[name] = split
        for name, column in self._numbers:
            found[name] = numbers[:, column]
        records: list[bytes] = whole.tolist()
        return records


def record_of(channel: int, stamp: int, sequence: int, data: bytes) -> bytes:
    """One message with its head."""
    head = np.array((Opcode.MESSAGE, HEAD_SIZE - PREFIX + len(data), channel, sequence, stamp, stamp), list(HEAD))
    return head.tobytes() + data
