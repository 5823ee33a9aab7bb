"""Bags of ROS 1 (.bag) and ROS 2 (.db3, or the folder with metadata.yaml), through rosbags."""

import bz2
from collections.abc import Iterator
from functools import partial
from pathlib import Path

import lz4.frame
import numpy as np
from rosbags.interfaces import Connection, MessageDefinitionFormat
from rosbags.rosbag1 import Reader as Ros1Reader
from rosbags.rosbag2 import Reader as Ros2Reader

from boom_mj.errors import LogError
from boom_mj.logs.channel import Batch, Channel, Format, Labels, Wanted
from boom_mj.logs.inflating import Inflater

COMPRESSIONS = {bz2.decompress: "bz2", lz4.frame.decompress: "lz4"}
BATCH = 4096  # messages that are handed on together
SCHEMAS = {
    MessageDefinitionFormat.NONE: "",
    MessageDefinitionFormat.MSG: "ros2msg",
    MessageDefinitionFormat.IDL: "ros2idl",
}


def _read(path: Path, wanted: Wanted) -> Iterator[Batch | Labels]:
    last = None
    try:
        ros1 = path.is_file() and path.suffix != ".db3"
        with (Ros1Reader if ros1 else Ros2Reader)(path) as reader:
            if isinstance(reader, Ros1Reader):
                _bound(reader, path)
            channels = {c.id: _channel(c, ros1) for c in reader.connections if wanted(c.topic)}
            waiting: dict[int, tuple[list[int], list[bytes]]] = {number: ([], []) for number in channels}
            for channel in channels.values():
                yield Batch(channel, np.empty(0, np.int64), [])
            chosen = [c for c in reader.connections if c.id in channels]
            for connection, last, data in reader.messages(chosen) if chosen else ():
                times, messages = waiting[connection.id]
                times.append(last)
                messages.append(bytes(data))
                if len(times) == BATCH:
                    yield Batch(channels[connection.id], np.array(times), messages)
                    waiting[connection.id] = [], []
            for number, (times, messages) in waiting.items():
                if times:
                    yield Batch(channels[number], np.array(times), messages)
    except (LogError, OSError):
        raise
    except Exception as error:  # rosbags and its databases have exceptions of their own
        readable = "without one readable message" if last is None else f"readable up to {last / 1e9:.3f} s"
        raise LogError(f"{path} is damaged, {readable}: {error}") from error


def _bound(reader: Ros1Reader, path: Path) -> None:
    """Let the chunks of a bag inflate within bounds."""
    inflater = Inflater(path.stat().st_size)
    for place, chunk in reader.chunks.items():
        bounded = partial(inflater.inflate, compression=COMPRESSIONS.get(chunk.decompressor, ""))
        reader.chunks[place] = chunk._replace(decompressor=bounded)


def _channel(connection: Connection, ros1: bool) -> Channel:
    definition = connection.msgdef
    schema = SCHEMAS[definition.format], definition.data.encode()
    return Channel(connection.id, connection.topic, connection.msgtype, "ros1" if ros1 else "cdr", *schema)


ROS1_BAG = Format("ROS 1 bag", lambda path, head: head.startswith(b"#ROSBAG V2") or path.suffix == ".bag", _read)
ROS2_BAG = Format(
    "ROS 2 bag",
    lambda path, head: path.suffix == ".db3" or (path / "metadata.yaml").is_file(),
    _read,
)
