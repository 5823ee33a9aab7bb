"""Recording -> MCAP file of ROS 2 messages, written whole or not at all; equal recordings give equal bytes."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any

import numpy as np
from mcap.writer import CompressionType, Writer

from boom_mj.errors import LogError
from boom_mj.files import whole_file
from boom_mj.logs.messages import make, typestore
from boom_mj.logs.scene import TYPES as SCENE_TYPES
from boom_mj.logs.scene import scene_messages
from boom_mj.logs.topics import LOGGED, METADATA, TOPICS, Topic, refuse_gaps
from boom_mj.recording import Recording, Scene

LAST_STAMP = 2**31 - 1  # s; ROS counts seconds in 32 bits


def write_mcap(
    recording: Recording,
    path: str | Path,
    variance: Mapping[str, float] | None = None,
    beside: Mapping[str, Recording] | None = None,
    scene: Scene | None = None,
    also: Iterable[tuple[int, str, Any]] = (),
) -> None:
    """Write a recording as a log; times are rounded to nanoseconds.

    Args:
        recording: signals to write; a topic without signals is left out.
        path: file to write, or to replace; its folder exists.
        variance: noise variance by IMU signal name, the same on all axes, for the covariances; 0 otherwise.
        beside: further recordings under topics with a prefix, such as {"/measured": log}; reading leaves them aside.
        scene: what a viewer shows moving, as /tf and /scene.
        also: further messages, such as pictures: stamp in ns, topic, message; taken one by one as they are written.

    Raises:
        LogError: a signal that no topic carries, signals of one topic with different times, a time or a value
            that a log cannot hold.
        OutputError: a file that cannot be written. The old file, if any, is untouched then.
    """
    variance = variance or {}
    parts = [_Part("", recording, variance), *(_Part(prefix, r, {}) for prefix, r in (beside or {}).items())]
    columns = [column for part in parts for column in part.columns()]
    with whole_file(path) as stream:
        _write(recording, columns, scene, also, stream)


def _stamps(recording: Recording, topic: Topic) -> np.ndarray:
    """Times of a topic's messages, (n,), ns."""
    present = [name for name in topic.signals.values() if name in recording]
    time = recording[present[0]].time
    for name in present:
        refuse_gaps(name, recording[name])
        if not np.array_equal(recording[name].time, time):
            raise LogError(f"'{name}' and '{present[0]}' share the messages of {topic.name} but not their times")
    if time[0] < 0 or time[-1] > LAST_STAMP:
        raise LogError(f"'{present[0]}' runs from {time[0]:.3f} to {time[-1]:.3f} s; a log holds 0 to {LAST_STAMP} s")
    stamps = np.round(time * 1e9).astype(np.int64)
    if (same := np.flatnonzero(np.diff(stamps) <= 0)).size:
        raise LogError(f"'{present[0]}' has two samples in one nanosecond at {time[same[0]]:.9f} s")
    return stamps


@dataclass(frozen=True)
class _Column:
    """The messages of one topic: name in the file, kind, stamps in ns, rows and variances by message field."""

    name: str
    topic: Topic
    stamps: np.ndarray
    rows: Mapping[str, np.ndarray]
    noise: Mapping[str, float]

    def message(self, i: int) -> bytes:
        time = make("builtin_interfaces/msg/Time", *divmod(int(self.stamps[i]), 10**9))
        header = make("std_msgs/msg/Header", stamp=time, frame_id=self.topic.frame_id)
        rows = {field: values[i] for field, values in self.rows.items()}
        message = self.topic.kind.pack(header, self.topic.channels, rows, self.noise)
        return bytes(typestore().serialize_cdr(message, self.topic.kind.ros_type))


@dataclass(frozen=True)
class _Part:
    """A recording and the prefix of its topics."""

    prefix: str
    recording: Recording
    variance: Mapping[str, float]

    def columns(self) -> list[_Column]:
        recording = self.recording
        if unknown := [name for name in (*recording.signals, *self.variance) if name not in LOGGED]:
            raise LogError(f"no topic carries {', '.join(unknown)}; a log holds {', '.join(LOGGED)}")
        found = []
        for topic in TOPICS:
            present = {field: name for field, name in topic.signals.items() if name in recording}
            if present:
                rows = {field: recording[name].values + 0.0 for field, name in present.items()}  # no negative zeros
                noise = {field: self.variance[name] for field, name in present.items() if name in self.variance}
                found.append(_Column(self.prefix + topic.name, topic, _stamps(recording, topic), rows, noise))
        if not found:
            raise LogError(f"recording '{recording.name}' has no signals to write")
        return found


def _write(
    recording: Recording,
    columns: list[_Column],
    scene: Scene | None,
    also: Iterable[tuple[int, str, Any]],
    stream: IO[bytes],
) -> None:
    writer = Writer(stream, compression=CompressionType.ZSTD)
    writer.start(profile="ros2", library="boom_mj")
    labels = {"name": recording.name, "machine": recording.machine, "description": recording.description}
    writer.add_metadata(METADATA, labels)

    types = {column.name: column.topic.kind.ros_type for column in columns} | (SCENE_TYPES if scene else {})
    schemas: dict[str, int] = {}
    channels: dict[str, int] = {}

    def register(ros_types: Mapping[str, str]) -> None:
        for ros_type in dict.fromkeys(ros_types.values()):
            if ros_type not in schemas:
                definition, _ = typestore().generate_msgdef(ros_type, ros_version=2)
                schemas[ros_type] = writer.register_schema(ros_type, "ros2msg", definition.encode())
        channels.update({name: writer.register_channel(name, "cdr", schemas[kind]) for name, kind in ros_types.items()})

    register(types)

    when = np.concatenate([column.stamps for column in columns])  # (N,) over all messages, ns
    which = np.repeat(np.arange(len(columns)), [column.stamps.size for column in columns])
    sample = np.concatenate([np.arange(column.stamps.size) for column in columns])
    for m in np.lexsort((which, when)):
        stamp, i, column = int(when[m]), int(sample[m]), columns[which[m]]
        writer.add_message(channels[column.name], stamp, column.message(i), stamp, i)
    for i, (stamp, name, message) in enumerate(scene_messages(scene) if scene else ()):
        writer.add_message(channels[name], stamp, bytes(typestore().serialize_cdr(message, types[name])), stamp, i)
    for i, (stamp, name, message) in enumerate(also):
        if name not in channels:
            register({name: message.__msgtype__})
        data = bytes(typestore().serialize_cdr(message, message.__msgtype__))
        writer.add_message(channels[name], stamp, data, stamp, i)
    writer.finish()
