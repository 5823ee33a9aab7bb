"""MCAP files, read from front to back so that a file that is cut off gives what it has."""

import struct
import warnings
import zlib
from collections.abc import Iterator
from io import BytesIO
from pathlib import Path
from typing import IO

import numpy as np
from mcap import records
from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.writer import MCAP0_MAGIC

from boom_mj.errors import LogError, LogWarning
from boom_mj.logs.channel import Batch, Channel, Format, Labels, Wanted
from boom_mj.logs.inflating import Inflater

HEAD = struct.Struct("<BQ")  # of a record: opcode, length
MESSAGE = struct.Struct("<HIQQ")  # channel, sequence, log time, publish time
CHUNK = struct.Struct("<QQQII")  # start, end, size and checksum of the content, length of the compression's name
LARGEST = 2**30  # bytes of a record
BATCH = 2**22  # bytes of messages that are handed on together


def _read(path: Path, wanted: Wanted) -> Iterator[Batch | Labels]:
    with path.open("rb") as stream:
        if (start := stream.read(len(MCAP0_MAGIC))) != MCAP0_MAGIC:
            raise LogError(f"{path} is {'empty' if not start else 'not an MCAP file'}")
        file = _McapFile(path, stream, wanted)
        try:
            yield from file.read()
        except (LogError, OSError):
            raise
        except Exception as error:  # broken bytes raise whatever the parser and the decompressor stumble over
            raise LogError(f"{path} is damaged, {file.readable()}: {error}") from error


MCAP = Format("MCAP file", lambda path, head: head.startswith(MCAP0_MAGIC) or path.suffix == ".mcap", _read)


class _McapFile:
    def __init__(self, path: Path, stream: IO[bytes], wanted: Wanted) -> None:
        self.path, self.stream, self.wanted = path, stream, wanted
        self.size = stream.seek(0, 2)
        self.inflater = Inflater(self.size)
        stream.seek(self.size - len(MCAP0_MAGIC))
        self.whole = stream.read() == MCAP0_MAGIC and self.size > len(MCAP0_MAGIC)
        self.schemas: dict[int, records.Schema] = {}
        self.channels: dict[int, Channel] = {}
        self.waiting: dict[int, tuple[list[int], list[bytes]]] = {}  # log times and messages by channel
        self.held = 0  # bytes of messages that wait
        self.count, self.last = 0, 0  # messages so far, latest log time, ns
        self.fresh: list[Channel] = []  # not yet announced
        self.lost = "what came after that is lost; without the end of the file there is no telling how much"

    def readable(self) -> str:
        """Up to when the file could be read."""
        return f"readable up to {self.last / 1e9:.3f} s" if self.count else "without one readable message"

    def read(self) -> Iterator[Batch | Labels]:
        self.stream.seek(len(MCAP0_MAGIC))
        checksum = zlib.crc32(MCAP0_MAGIC)
        ended = False
        while not ended and len(head := self.stream.read(HEAD.size)) == HEAD.size:
            opcode, length = HEAD.unpack(head)
            if min(length, self.size) > LARGEST:
                raise ValueError(f"a record of {length} bytes; up to {LARGEST} are read")
            content = self.stream.read(length)
            cut = len(content) < length
            if cut and self.whole:
                raise ValueError(f"a record of {length} bytes where only {len(content)} are left")
            if opcode == Opcode.CHUNK:
                self._chunk(content, cut)
            elif not cut and opcode == Opcode.METADATA:
                record = records.Metadata.read(ReadDataStream(BytesIO(content)))
                yield Labels(record.name, record.metadata)
            elif not cut and opcode == Opcode.DATA_END:
                (expected,) = struct.unpack_from("<I", content)
                if expected and expected != checksum:
                    raise ValueError("the checksum of the messages does not fit")
                ended = True
            elif not cut:
                self._record(opcode, content, 0, length)
            checksum = zlib.crc32(content, zlib.crc32(head, checksum))
            yield from self._batches(BATCH)
        if not ended and self.whole:
            raise ValueError("the messages have no end")
        yield from self._batches(0)
        if not ended:
            self._report_cut()
        elif not self.whole:
            warnings.warn(f"{self.path} is cut off behind its last message; none is lost", LogWarning, stacklevel=2)

    def _report_cut(self) -> None:
        if not self.count:
            raise LogError(f"{self.path} is cut off: it ends in the middle, {self.readable()}")
        read = f"{self.count} messages are read, up to {self.last / 1e9:.3f} s"
        warnings.warn(f"{self.path} is cut off: {read}; {self.lost}", LogWarning, stacklevel=2)

    def _chunk(self, content: bytes, cut: bool) -> None:
        """Messages of a chunk; of a broken one those before the break."""
        if cut and len(content) < CHUNK.size + 16:
            return
        _, end, size, expected, name = CHUNK.unpack_from(content)
        if size > LARGEST:
            raise ValueError(f"a chunk of {size} bytes; up to {LARGEST} are read")
        compression = content[CHUNK.size : CHUNK.size + name].decode()
        data = self.inflater.inflate(content[CHUNK.size + name + 8 :], compression, size)
        if not cut and (len(data) != size or (expected and zlib.crc32(data) != expected)):
            raise ValueError("the checksum of a chunk does not fit")
        at = 0
        while at + HEAD.size <= len(data):
            opcode, length = HEAD.unpack_from(data, at)
            at += HEAD.size
            if at + length > len(data):
                break
            self._record(opcode, data, at, length)
            at += length
        if cut:
            self.lost = (
                f"the chunk at the cut went on to {end / 1e9:.3f} s: {max(end - self.last, 0) / 1e9:.3f} s "
                f"({size - at} of its {size} bytes) are lost, and whatever came after it"
            )
        elif at != len(data):
            raise ValueError("a chunk ends in the middle of a record")

    def _record(self, opcode: int, data: bytes, at: int, length: int) -> None:
        if opcode == Opcode.MESSAGE:
            number, _, log_time, _ = MESSAGE.unpack_from(data, at)
            if number not in self.channels:
                raise ValueError(f"a message of channel {number}, which the file does not announce")
            self.count += 1
            self.last = max(self.last, log_time)
            if number in self.waiting:
                times, messages = self.waiting[number]
                times.append(log_time)
                messages.append(data[at + MESSAGE.size : at + length])
                self.held += length
        elif opcode == Opcode.SCHEMA:
            schema = records.Schema.read(ReadDataStream(BytesIO(data[at : at + length])))
            self.schemas[schema.id] = schema
        elif opcode == Opcode.CHANNEL:
            channel = records.Channel.read(ReadDataStream(BytesIO(data[at : at + length])))
            if channel.id not in self.channels:
                known = self.schemas.get(channel.schema_id)
                name, *schema = (known.name, known.encoding, known.data) if known else ("no schema", "", b"")
                self.channels[channel.id] = Channel(channel.id, channel.topic, name, channel.message_encoding, *schema)
                if self.wanted(channel.topic):
                    self.waiting[channel.id] = [], []
                    self.fresh.append(self.channels[channel.id])

    def _batches(self, enough: int) -> Iterator[Batch]:
        """What waits, if it is enough."""
        for channel in self.fresh:
            yield Batch(channel, np.empty(0, np.int64), [])
        self.fresh = []
        if self.held > enough or not enough:
            for number, (times, messages) in self.waiting.items():
                if times:
                    yield Batch(self.channels[number], np.array(times, np.int64), messages)
                    self.waiting[number] = [], []
            self.held = 0
