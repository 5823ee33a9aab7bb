"""MCAP file of ROS 2 messages -> Recording; what is wrong is refused by name, never repaired in silence."""

from collections.abc import Mapping
from pathlib import Path
from typing import IO, Any

import numpy as np
from mcap.reader import NonSeekingReader, SeekingReader
from mcap.writer import MCAP0_MAGIC

from boom_mj.errors import LogError
from boom_mj.logs.messages import typestore
from boom_mj.logs.topics import METADATA, TOPIC_NAMED, Topic, refuse_gaps
from boom_mj.recording import Recording, Signal, named_signal


def read_mcap(path: str | Path) -> Recording:
    """Read a log; times are the header stamps.

    Topics that the table does not know (cameras) are left aside, topics that are not there leave their signals
    out. Without a metadata record the recording is called like the file and its machine is "".

    Args:
        path: MCAP file with ROS 2 messages in CDR.

    Raises:
        LogError: a file that is missing, damaged, cut off or no MCAP file; a topic of the wrong type or frame;
            stamps that do not increase; missing joints; missing values. The message names file, topic and time.
    """
    path = Path(path)
    try:
        with path.open("rb") as stream:
            _check_ends(stream, path)
            labels, messages = _load(stream, path)
    except OSError as error:
        raise LogError(f"{path} cannot be read: {error.strerror or error}") from error
    if not messages:
        raise LogError(f"{path} has no messages on any of the topics {', '.join(TOPIC_NAMED)}")
    signals: dict[str, Signal] = {}
    for name, topic in TOPIC_NAMED.items():
        if name in messages:
            try:
                signals |= _signals(topic, messages[name])
            except LogError as error:
                raise LogError(f"{path}, topic {name}: {error}") from error
    return Recording(
        name=labels.get("name", path.stem),
        machine=labels.get("machine", ""),
        description=labels.get("description", ""),
        signals=signals,
    )


def _check_ends(stream: IO[bytes], path: Path) -> None:
    """An MCAP file begins and ends with the same eight bytes."""
    if (start := stream.read(len(MCAP0_MAGIC))) != MCAP0_MAGIC:
        raise LogError(f"{path} is {'empty' if not start else 'not an MCAP file'}")
    size = stream.seek(0, 2)
    stream.seek(max(size - len(MCAP0_MAGIC), len(MCAP0_MAGIC)))
    if stream.read() != MCAP0_MAGIC:
        raise LogError(f"{path} is cut off: it ends in the middle, {_readable(stream)}")


def _load(stream: IO[bytes], path: Path) -> tuple[Mapping[str, str], Mapping[str, list[bytes]]]:
    """Metadata of the experiment and the raw messages by topic, in the order of their log times."""
    messages: dict[str, list[bytes]] = {}
    checked: set[int] = set()
    try:
        stream.seek(0)
        reader = SeekingReader(stream, validate_crcs=True)
        labels = next((m.metadata for m in reader.iter_metadata() if m.name == METADATA), {})
        for schema, channel, message in reader.iter_messages(topics=set(TOPIC_NAMED)):
            if channel.id not in checked:
                _check_type(TOPIC_NAMED[channel.topic], schema.name if schema else "no schema", channel, path)
                checked.add(channel.id)
            messages.setdefault(channel.topic, []).append(message.data)
    except (LogError, OSError):
        raise
    except Exception as error:  # broken bytes raise whatever the parser and the decompressor stumble over
        raise LogError(f"{path} is damaged, {_readable(stream)}: {error}") from error
    return labels, messages


def _check_type(topic: Topic, ros_type: str, channel: Any, path: Path) -> None:
    is_, must = (ros_type, channel.message_encoding), (topic.kind.ros_type, "cdr")
    if is_ != must:
        raise LogError(f"{path}, topic {topic.name}: messages are {' in '.join(is_)}; must be {' in '.join(must)}")


def _readable(stream: IO[bytes]) -> str:
    """Up to when the messages of a broken file can be read."""
    last = None
    try:
        stream.seek(0)
        for _, _, message in NonSeekingReader(stream, validate_crcs=True).iter_messages(log_time_order=False):
            last = message.log_time
    except Exception:  # the break itself: what came before it counts
        pass
    return "without one readable message" if last is None else f"readable up to {last / 1e9:.3f} s"


def _signals(topic: Topic, messages: list[bytes]) -> dict[str, Signal]:
    stamps = np.empty(len(messages), np.int64)  # ns
    rows: dict[str, list[np.ndarray | None]] = {field: [] for field in topic.signals}
    for i, data in enumerate(messages):
        try:
            message: Any = typestore().deserialize_cdr(data, topic.kind.ros_type)
            stamps[i] = message.header.stamp.sec * 10**9 + message.header.stamp.nanosec
            if not topic.accepts(message.header.frame_id):
                raise ValueError(f"frame_id is '{message.header.frame_id}'; must be '{topic.frame_id}'")
            for field, column in rows.items():
                column.append(topic.kind.unpack(message, field, topic.channels))
        except Exception as error:  # the CDR reader has no exception of its own for short or foreign bytes
            after = f"after {stamps[i - 1] / 1e9:.3f} s" if i else "the first one"
            raise LogError(f"message {i + 1} ({after}) cannot be read: {error}") from error
    signals = {}
    for field, column in rows.items():
        sizes = np.array([0 if row is None else row.size for row in column])
        if (change := np.flatnonzero(sizes != sizes[0])).size:
            i = change[0]
            raise LogError(f"{field} changes from {sizes[0]} to {sizes[i]} values at {stamps[i] / 1e9:.3f} s")
        if sizes[0]:
            name = topic.signals[field]
            signals[name] = named_signal(name, stamps / 1e9, np.array(column, dtype=np.float64))
            refuse_gaps(name, signals[name])
    return signals
