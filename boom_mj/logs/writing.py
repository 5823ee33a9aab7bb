"""Recording -> MCAP file of ROS 2 messages, written whole or not at all; equal recordings give equal bytes."""

import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import IO

import numpy as np
from mcap.writer import CompressionType, Writer

from boom_mj.errors import LogError
from boom_mj.logs.messages import make, typestore
from boom_mj.logs.topics import LOGGED, METADATA, TOPICS, Topic, refuse_gaps
from boom_mj.recording import Recording

LAST_STAMP = 2**31 - 1  # s; ROS counts seconds in 32 bits


def write_mcap(recording: Recording, path: str | Path, variance: Mapping[str, float] | None = None) -> None:
    """Write a recording as a log; times are rounded to nanoseconds.

    Args:
        recording: signals to write; a topic without signals is left out.
        path: file to write, or to replace; its folder exists.
        variance: noise variance by IMU signal name, the same on all axes, for the covariances; 0 otherwise.

    Raises:
        LogError: a signal that no topic carries, signals of one topic with different times, a time or a value
            that a log cannot hold, a file that cannot be written. The old file, if any, is untouched then.
    """
    variance = variance or {}
    if unknown := [name for name in (*recording.signals, *variance) if name not in LOGGED]:
        raise LogError(f"no topic carries {', '.join(unknown)}; a log holds {', '.join(LOGGED)}")
    topics = [topic for topic in TOPICS if any(name in recording for name in topic.signals.values())]
    if not topics:
        raise LogError(f"recording '{recording.name}' has no signals to write")
    stamps = [_stamps(recording, topic) for topic in topics]
    with whole_file(Path(path)) as stream:
        _write(recording, topics, stamps, variance, stream)


@contextmanager
def whole_file(path: Path) -> Iterator[IO[bytes]]:
    """Stream to a file that appears under its name when the block ends, and not at all if it fails."""
    part = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        try:
            with part.open("wb") as stream:
                yield stream
            os.replace(part, path)
        finally:
            part.unlink(missing_ok=True)
    except OSError as error:
        raise LogError(f"{path} cannot be written: {error.strerror or error}") from error


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


def _write(
    recording: Recording,
    topics: list[Topic],
    stamps: list[np.ndarray],
    variance: Mapping[str, float],
    stream: IO[bytes],
) -> None:
    writer = Writer(stream, compression=CompressionType.ZSTD)
    writer.start(profile="ros2", library="boom_mj")
    labels = {"name": recording.name, "machine": recording.machine, "description": recording.description}
    writer.add_metadata(METADATA, labels)

    schemas: dict[str, int] = {}
    for ros_type in dict.fromkeys(topic.kind.ros_type for topic in topics):
        definition, _ = typestore().generate_msgdef(ros_type, ros_version=2)
        schemas[ros_type] = writer.register_schema(ros_type, "ros2msg", definition.encode())
    channels = [writer.register_channel(topic.name, "cdr", schemas[topic.kind.ros_type]) for topic in topics]
    rows = [{f: recording[s].values for f, s in topic.signals.items() if s in recording} for topic in topics]
    noise = [{f: variance[s] for f, s in topic.signals.items() if s in variance} for topic in topics]

    when = np.concatenate(stamps)  # (N,) over all messages, ns
    which = np.repeat(np.arange(len(topics)), [s.size for s in stamps])
    sample = np.concatenate([np.arange(s.size) for s in stamps])
    for m in np.lexsort((which, when)):
        stamp, k, i = int(when[m]), which[m], int(sample[m])
        topic = topics[k]
        time = make("builtin_interfaces/msg/Time", *divmod(stamp, 10**9))
        header = make("std_msgs/msg/Header", stamp=time, frame_id=topic.frame_id)
        message = topic.kind.pack(header, topic.channels, {f: v[i] for f, v in rows[k].items()}, noise[k])
        data = bytes(typestore().serialize_cdr(message, topic.kind.ros_type))
        writer.add_message(channels[k], log_time=stamp, publish_time=stamp, sequence=i, data=data)
    writer.finish()
