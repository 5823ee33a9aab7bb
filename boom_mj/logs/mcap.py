"""Recordings as MCAP files of ROS 2 messages, which Foxglove, PlotJuggler, Rerun and `ros2 bag` open unaided."""

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from mcap.exceptions import McapError
from mcap.reader import make_reader
from mcap.writer import Writer

from boom_mj.errors import LogError
from boom_mj.logs.topics import STORE, TOPICS, header
from boom_mj.recording import Recording, Signal, signal_of_kind

Array = np.ndarray
NANO = 1_000_000_000
MAGIC = b"\x89MCAP0\r\n"  # opens and closes every MCAP file


def write_mcap(recording: Recording, path: Path | str) -> None:
    """Write a recording; the file appears whole or not at all, the same recording gives the same bytes.

    Raises:
        LogError: the file cannot be written.
    """
    try:
        with whole_file(Path(path)) as stream:
            writer = Writer(stream)
            writer.start(profile="ros2", library="boom_mj")
            writer.add_metadata(
                "experiment",
                {"name": recording.name, "machine": recording.machine, "description": recording.description},
            )
            channels = {}
            for name, topic in TOPICS.items():
                if topic.signals[0] in recording:
                    text, _ = STORE.generate_msgdef(topic.type, ros_version=2)
                    schema = writer.register_schema(topic.type, "ros2msg", text.encode())
                    channels[name] = writer.register_channel(name, "cdr", schema)
            for stamp, name, message in _messages(recording, tuple(channels)):
                writer.add_message(channels[name], stamp, bytes(STORE.serialize_cdr(message, TOPICS[name].type)), stamp)
            writer.finish()
    except OSError as error:
        raise LogError(f"{path}: cannot be written ({error.strerror})") from error


def read_mcap(path: Path | str) -> Recording:
    """Read a log with the topics of `TOPICS`; other topics are passed over.

    Raises:
        LogError: no file, no MCAP, cut off, or a topic whose type, joints or stamps are wrong; it is named.
    """
    rows: dict[str, tuple[list[float], list[Any]]] = {}
    name = machine = description = ""
    try:
        with open(path, "rb") as stream:
            _refuse_fragments(stream, path)
            reader = make_reader(stream)
            for record in reader.iter_metadata():
                if record.name == "experiment":
                    name, machine, description = (
                        record.metadata.get(key, "") for key in ("name", "machine", "description")
                    )
            for schema, channel, message in reader.iter_messages(topics=list(TOPICS), log_time_order=False):
                topic = TOPICS[channel.topic]
                if schema is None or schema.name != topic.type or channel.message_encoding != "cdr":
                    found = f"{schema.name if schema else 'no schema'} in {channel.message_encoding}"
                    raise LogError(f"{path}: {channel.topic} holds {found}; expected {topic.type} in cdr")
                decoded: Any = STORE.deserialize_cdr(message.data, topic.type)
                stamp = decoded.header.stamp
                times, values = rows.setdefault(channel.topic, ([], []))
                times.append(stamp.sec + stamp.nanosec / NANO)
                try:
                    values.append(topic.read(decoded))
                except LogError as error:
                    raise LogError(f"{path}: {channel.topic} at {times[-1]:.3f} s: {error}") from error
    except OSError as error:
        raise LogError(f"{path}: cannot be read ({error.strerror})") from error
    except LogError:
        raise
    except (McapError, ValueError, KeyError, IndexError, RuntimeError, EOFError) as error:
        raise LogError(f"{path}: not a whole MCAP file ({type(error).__name__}: {error})") from error
    if not rows:
        raise LogError(f"{path}: holds none of the topics {', '.join(TOPICS)}")
    signals: dict[str, Signal] = {}
    for topic_name, (times, values) in rows.items():
        signals.update(_signals(f"{path}: {topic_name}", topic_name, np.array(times), values))
    return Recording(name or Path(path).stem, machine, description, signals)


def _refuse_fragments(stream: BinaryIO, path: Path | str) -> None:
    """What does not begin and end with the mark of MCAP is another file, or part of one."""
    start = stream.read(len(MAGIC))
    if start != MAGIC:
        raise LogError(f"{path}: not an MCAP file")
    stream.seek(-len(MAGIC), os.SEEK_END)
    if stream.read() != MAGIC or stream.tell() < 2 * len(MAGIC):
        raise LogError(f"{path}: cut off after {stream.tell()} bytes, its end is missing")
    stream.seek(0)


def _signals(place: str, topic: str, time: Array, values: list[Any]) -> dict[str, Signal]:
    backward = np.flatnonzero(np.diff(time) <= 0)
    if backward.size:
        k = backward[0]
        raise LogError(f"{place}: stamp {time[k + 1]:.6f} s follows {time[k]:.6f} s; stamps must increase")
    found = {}
    for number, signal in enumerate(TOPICS[topic].signals):
        column = [row[signal] for row in values]
        lacking = [k for k, row in enumerate(column) if row is None]
        if not lacking:
            found[signal] = signal_of_kind(signal, time, np.array(column))
        elif number == 0 or len(lacking) < len(column):
            raise LogError(f"{place}: the message at {time[lacking[0]]:.3f} s carries no {signal}")
    return found


def _messages(recording: Recording, topics: tuple[str, ...]) -> Iterator[tuple[int, str, Any]]:
    """Messages of all topics in the order of time."""
    queue = []
    for order, name in enumerate(topics):
        time = recording[TOPICS[name].signals[0]].time
        queue += [(round(t * NANO), order, k) for k, t in enumerate(time)]
    for stamp, order, k in sorted(queue):
        topic = TOPICS[topics[order]]
        rows = {signal: recording[signal].values[k] for signal in topic.signals if signal in recording}
        yield stamp, topics[order], topic.write(header(stamp // NANO, stamp % NANO, topic.frame), rows)


@contextmanager
def whole_file(path: Path) -> Iterator[BinaryIO]:
    """A stream whose bytes appear under `path` when all of them are there, and not at all otherwise."""
    handle, temporary = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
    try:
        with os.fdopen(handle, "wb") as stream:
            yield stream
        os.chmod(temporary, 0o644)
        os.replace(temporary, path)
    except BaseException:
        os.unlink(temporary)
        raise
