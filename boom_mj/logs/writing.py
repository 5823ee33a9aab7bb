"""Recording -> MCAP file of ROS 2 messages, written whole or not at all; equal recordings give equal bytes."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any

import numpy as np

from boom_mj.errors import LogError
from boom_mj.files import whole_file
from boom_mj.logs.container import Container
from boom_mj.logs.messages import make, typestore
from boom_mj.logs.scene import TYPES as SCENE_TYPES
from boom_mj.logs.scene import frames, shapes
from boom_mj.logs.serialising import Pack, Serialiser, record_of, serialise
from boom_mj.logs.topics import LOGGED, METADATA, TOPICS, Topic, refuse_gaps
from boom_mj.recording import Recording, Scene

LAST_STAMP = 2**31 - 1  # s; ROS counts seconds in 32 bits
BLOCK = 50_000  # messages that are in memory at a time


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
    """The messages of one topic, which differ in stamps and numbers only.

    Attributes:
        name: topic in the file.
        ros_type: of the messages.
        pack: message from its stamp and numbers.
        stamps: (n,), ns.
        numbers: (n, k).
    """

    name: str
    ros_type: str
    pack: Pack
    stamps: np.ndarray
    numbers: np.ndarray


def _topic_column(name: str, topic: Topic, recording: Recording, variance: Mapping[str, float]) -> _Column:
    present = {field: signal for field, signal in topic.signals.items() if signal in recording}
    noise = {field: variance[signal] for field, signal in present.items() if signal in variance}
    values = [recording[signal].values for signal in present.values()]
    ends = np.cumsum([rows.shape[1] for rows in values])[:-1]

    def pack(stamp: Any, numbers: np.ndarray) -> Any:
        header = make("std_msgs/msg/Header", stamp=stamp, frame_id=topic.frame_id)
        return topic.kind.pack(header, topic.channels, dict(zip(present, np.split(numbers, ends))), noise)

    numbers = np.concatenate(values, axis=1) + 0.0  # no negative zeros
    return _Column(name, topic.kind.ros_type, pack, _stamps(recording, topic), numbers)


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
        found = [
            _topic_column(self.prefix + topic.name, topic, recording, self.variance)
            for topic in TOPICS
            if any(name in recording for name in topic.signals.values())
        ]
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
    container = Container(stream, profile="ros2", library="boom_mj")
    labels = {"name": recording.name, "machine": recording.machine, "description": recording.description}
    container.metadata(METADATA, labels)

    schemas: dict[str, int] = {}
    channels: dict[str, int] = {}

    def register(ros_types: Mapping[str, str]) -> None:
        for ros_type in dict.fromkeys(ros_types.values()):
            if ros_type not in schemas:
                definition, _ = typestore().generate_msgdef(ros_type, ros_version=2)
                schemas[ros_type] = container.schema(ros_type, definition)
        channels.update({name: container.channel(name, schemas[kind]) for name, kind in ros_types.items()})

    def write_one(stamp: int, name: str, message: Any, sequence: int) -> None:
        record = record_of(channels[name], stamp, sequence, serialise(message))
        container.messages([record], np.array([len(record)]), np.array([channels[name]]), np.array([stamp]))

    register({column.name: column.ros_type for column in columns} | (SCENE_TYPES if scene else {}))
    if scene:
        write_one(*shapes(scene), 0)
        columns = [*columns, _Column("/tf", SCENE_TYPES["/tf"], *frames(scene))]
    _write_columns(container, columns, channels)
    for i, (stamp, name, message) in enumerate(also):
        if name not in channels:
            register({name: message.__msgtype__})
        write_one(stamp, name, message, i)
    container.finish()


def _write_columns(container: Container, columns: list[_Column], channels: Mapping[str, int]) -> None:
    """Write messages in the order of their stamps, a block at a time; equal stamps in the order of the columns."""
    serialisers = [Serialiser(column.pack, column.numbers.shape[1]) for column in columns]
    sizes = np.array([serialiser.size for serialiser in serialisers])
    when = np.concatenate([column.stamps for column in columns])  # (N,) over all messages, ns
    which = np.repeat(np.arange(len(columns)), [column.stamps.size for column in columns])
    order = np.lexsort((which, when))
    numbers = np.array([channels[column.name] for column in columns])
    done = np.zeros(len(columns), int)
    for start in range(0, len(order), BLOCK):
        block = order[start : start + BLOCK]
        records = np.empty(len(block), object)
        for c, (column, serialiser) in enumerate(zip(columns, serialisers)):
            of = which[block] == c
            part = slice(done[c], done[c] + np.count_nonzero(of))
            found = serialiser.records(numbers[c], column.stamps[part], column.numbers[part], part.start)
            records[of] = np.array([*found, None], object)[:-1]  # without the None, bytes would become an "S" array
            done[c] = part.stop
        container.messages(records.tolist(), sizes[which[block]], numbers[which[block]], when[block])
