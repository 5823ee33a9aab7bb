"""The container of a log: an MCAP file whose messages come by the thousand, in chunks with an index.

Records are the mcap library's, whose own writer takes messages one by one: ten times the time of all else.
"""

import zlib
from collections import Counter
from collections.abc import Mapping, Sequence
from typing import IO

import numpy as np
import zstandard
from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import (
    Channel,
    Chunk,
    ChunkIndex,
    DataEnd,
    Footer,
    Header,
    McapRecord,
    Metadata,
    MetadataIndex,
    Schema,
    Statistics,
    SummaryOffset,
)
from mcap.writer import MCAP0_MAGIC

Array = np.ndarray
CHUNK = 1 << 20  # bytes of messages after which a chunk ends
LEVEL = 1  # of compression: two thirds of the time of 3, zstd's own choice, and on logs a tenth smaller
FOOTER = 20  # bytes in a footer

HEAD = (
    ("opcode", "u1"),
    ("length", "<u8"),  # of what follows
    ("channel", "<u2"),
    ("sequence", "<u4"),
    ("log_time", "<u8"),
    ("publish_time", "<u8"),
)
"""What stands in front of the data of every message."""
HEAD_SIZE = np.dtype(list(HEAD)).itemsize
PREFIX = 9  # bytes of opcode and length, which the length does not count


class Container:
    """An MCAP file that grows: metadata first, then channels and messages; `finish` ends it."""

    def __init__(self, stream: IO[bytes], profile: str, library: str) -> None:
        self._stream, self._place = stream, 0
        self._compressor = zstandard.ZstdCompressor(LEVEL)
        self._schemas: list[Schema] = []
        self._channels: list[Channel] = []
        self._metadata: list[MetadataIndex] = []
        self._chunks: list[ChunkIndex] = []
        self._counts: Counter[int] = Counter()
        self._first, self._last = 2**64 - 1, 0  # ns
        self._pending: list[bytes] = []  # records of the chunk
        self._index: list[tuple[Array, Array, Array]] = []  # channels, stamps and places of its messages
        self._size = 0  # bytes of it
        self._write(MCAP0_MAGIC)
        self._write(_record(Header(profile, library)))

    def metadata(self, name: str, labels: Mapping[str, str]) -> None:
        """Add a record of names and texts."""
        data = _record(Metadata(name=name, metadata=dict(labels)))
        self._metadata.append(MetadataIndex(offset=self._place, length=len(data), name=name))
        self._write(data)

    def schema(self, name: str, definition: str) -> int:
        """Add a ROS 2 message type; its number."""
        schema = Schema(id=len(self._schemas) + 1, data=definition.encode(), encoding="ros2msg", name=name)
        self._schemas.append(schema)
        self._pend(_record(schema))
        return schema.id

    def channel(self, topic: str, schema: int) -> int:
        """Add a topic of CDR messages; its number."""
        number = len(self._channels) + 1
        channel = Channel(id=number, topic=topic, message_encoding="cdr", metadata={}, schema_id=schema)
        self._channels.append(channel)
        self._pend(_record(channel))
        return number

    def messages(self, records: Sequence[bytes], sizes: Array, channels: Array, stamps: Array) -> None:
        """Add messages in this order.

        Args:
            records: n messages with their heads.
            sizes: of those, (n,), bytes.
            channels: their numbers, (n,).
            stamps: their times, (n,), ns.
        """
        ends = np.cumsum(sizes)
        done = 0
        while done < len(records):
            begun = self._size - (ends[done - 1] if done else 0)  # a record ends at `begun + ends` of its chunk
            stop = min(int(np.searchsorted(ends + begun, CHUNK, "right")) + 1, len(records))
            part = slice(done, stop)
            self._pending += records[part]
            self._index.append((channels[part], stamps[part], ends[part] - sizes[part] + begun))
            self._size = int(ends[stop - 1] + begun)
            done = stop
            self._end_full_chunk()

    def finish(self) -> None:
        """Write what is pending and the summary; the stream stays open."""
        if self._index:
            self._end_chunk()
        self._write(_record(DataEnd(0)))
        start, summary, offsets = self._place, bytearray(), []
        groups: tuple[tuple[Opcode, Sequence[McapRecord]], ...] = (
            (Opcode.SCHEMA, self._schemas),
            (Opcode.CHANNEL, self._channels),
            (Opcode.STATISTICS, [self._statistics()]),
            (Opcode.CHUNK_INDEX, self._chunks),
            (Opcode.ATTACHMENT_INDEX, []),
            (Opcode.METADATA_INDEX, self._metadata),
        )
        for opcode, records in groups:
            group = b"".join(map(_record, records))
            offsets.append(SummaryOffset(opcode, start + len(summary), len(group)))
            summary += group
        footer = Footer(summary_start=start, summary_offset_start=start + len(summary), summary_crc=0)
        summary += b"".join(map(_record, offsets))
        footer.summary_crc = zlib.crc32(summary + _record(footer)[: PREFIX + FOOTER - 4])
        self._write(bytes(summary) + _record(footer) + MCAP0_MAGIC)

    def _statistics(self) -> Statistics:
        return Statistics(
            attachment_count=0,
            channel_count=len(self._channels),
            channel_message_counts=dict(self._counts),
            chunk_count=len(self._chunks),
            message_count=self._counts.total(),
            metadata_count=len(self._metadata),
            message_start_time=self._first if self._counts else 0,
            message_end_time=self._last,
            schema_count=len(self._schemas),
        )

    def _pend(self, data: bytes) -> None:
        self._pending.append(data)
        self._size += len(data)
        self._end_full_chunk()

    def _end_full_chunk(self) -> None:
        if self._size > CHUNK and self._index:
            self._end_chunk()

    def _end_chunk(self) -> None:
        channels, stamps, places = (np.concatenate(column) for column in zip(*self._index))
        first, last = int(stamps.min()), int(stamps.max())
        plain = b"".join(self._pending)
        packed = self._compressor.compress(plain)
        chunk = Chunk(
            compression="zstd",
            data=packed,
            message_start_time=first,
            message_end_time=last,
            uncompressed_crc=zlib.crc32(plain),
            uncompressed_size=len(plain),
        )
        data, start, offsets = _record(chunk), self._place, {}
        self._write(data)
        begun = self._place
        numbers, firsts = np.unique(channels, return_index=True)
        for number in numbers[np.argsort(firsts)].tolist():
            of = channels == number
            entries = np.stack([stamps[of], places[of]], axis=1).astype("<u8").tobytes()
            body = number.to_bytes(2, "little") + len(entries).to_bytes(4, "little") + entries
            offsets[number] = self._place
            self._write(bytes([Opcode.MESSAGE_INDEX]) + len(body).to_bytes(8, "little") + body)
            self._counts[number] += int(of.sum())
        self._chunks.append(
            ChunkIndex(
                message_start_time=first,
                message_end_time=last,
                chunk_start_offset=start,
                chunk_length=len(data),
                message_index_offsets=offsets,
                message_index_length=self._place - begun,
                compression="zstd",
                compressed_size=len(packed),
                uncompressed_size=len(plain),
            )
        )
        self._first, self._last = min(self._first, first), max(self._last, last)
        self._pending, self._index, self._size = [], [], 0

    def _write(self, data: bytes) -> None:
        self._stream.write(data)
        self._place += len(data)


def _record(record: McapRecord) -> bytes:
    builder = RecordBuilder()
    record.write(builder)
    return bytes(builder.end())
