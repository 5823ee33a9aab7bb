"""Log of any format -> Recording; what is wrong is refused by name, never repaired in silence."""

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from boom_mj.errors import LogError, LogWarning
from boom_mj.logs.channel import Batch, Channel
from boom_mj.logs.checks import DRIVING, checked
from boom_mj.logs.encodings import Decoder, decoder_of
from boom_mj.logs.formats import format_of, log_file
from boom_mj.logs.intake import Intake, Part
from boom_mj.logs.merging import merged, with_shared_times
from boom_mj.logs.topic_map import TopicMap, own_map
from boom_mj.logs.topics import METADATA
from boom_mj.recording import Recording, Signal

MOST_FLAWS = 12  # told of a log


def read_log(path: str | Path, topic_map: TopicMap | None = None) -> Recording:
    """Read a log: MCAP, a bag of ROS 1 or ROS 2, or a CSV table.

    Without a topic map the topics are those that `write_mcap` writes: others (cameras) are left aside, those that
    are not there leave their signals out. Without a metadata record the recording is called like the file and its
    machine is "". Flaws that do not stop the use of a log are told by `LogWarning`.

    Raises:
        LogError: a file that is missing, damaged or of no known format; a topic of the wrong type or frame; a clock
            that was set back; missing joints; holes in joint angles. The message names file, topic and time.
    """
    path = log_file(Path(path))
    reader = _Reader(path, topic_map or own_map())
    with _warned_once(path):
        return _read(path, reader)


def _read(path: Path, reader: "_Reader") -> Recording:
    try:
        for item in format_of(path).read(path, reader.wants):
            if isinstance(item, Batch):
                reader.take(item)
            elif item.name == METADATA:
                reader.labels = dict(item.values)
    except OSError as error:
        raise LogError(f"{path} cannot be read: {error.strerror or error}") from error
    labels = reader.labels
    return Recording(
        name=labels.get("name", path.stem),
        machine=labels.get("machine", ""),
        description=labels.get("description", ""),
        signals=reader.signals(),
    )


@contextmanager
def _warned_once(path: Path) -> Iterator[None]:
    """All that is told about a log in one warning; the same is said once, of the signals of a topic."""
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        try:
            yield
        finally:
            others = [warning for warning in told if not issubclass(warning.category, LogWarning)]
            flaws = list(dict.fromkeys(str(warning.message) for warning in told if warning not in others))
    for warning in others:
        warnings.warn_explicit(warning.message, warning.category, warning.filename, warning.lineno)
    if flaws:
        more = [f"and {len(flaws) - MOST_FLAWS} more"] if len(flaws) > MOST_FLAWS else []
        text = "; ".join(flaws[:MOST_FLAWS] + more)
        warnings.warn(text if text.startswith(str(path)) else f"{path}: {text}", LogWarning, stacklevel=5)


def read_mcap(path: str | Path) -> Recording:
    """Read a log that `write_mcap` wrote, or one with the same topics; see `read_log`."""
    return read_log(path)


class _Reader:
    """Goes through a log once and hands every entry of the map its numbers."""

    def __init__(self, path: Path, topic_map: TopicMap) -> None:
        self.path, self.map = path, topic_map
        self.labels: dict[str, str] = {}
        self.intakes = [Intake(entry) for entry in topic_map.entries]
        self.by_topic: dict[str, list[Intake]] = {}
        for intake in self.intakes:
            self.by_topic.setdefault(intake.entry.topic, []).append(intake)
        self.decoders: dict[int, Decoder] = {}
        self.there: dict[str, int] = {}  # messages by topic; all topics of the log

    def wants(self, topic: str) -> bool:
        self.there.setdefault(topic, 0)
        return topic in self.by_topic

    def take(self, batch: Batch) -> None:
        if not len(batch.messages):
            return
        channel, intakes = batch.channel, self.by_topic[batch.channel.topic]
        self.there[channel.topic] += len(batch.messages)
        fields = tuple(dict.fromkeys(field for intake in intakes for field in intake.fields))
        try:
            if channel.id not in self.decoders:
                self._check_type(channel, intakes)
                self.decoders[channel.id] = decoder_of(channel)
            for group in self.decoders[channel.id].decode(batch.messages, fields):
                for intake in intakes:
                    intake.take(batch, group)
        except LogError as error:
            raise self._named(channel.topic, error) from error
        except ValueError as error:
            index = getattr(error, "index", 0)
            when = f"the message recorded at {batch.log_time[index] / 1e9:.3f} s cannot be read"
            raise self._named(channel.topic, f"{when}: {error}") from error

    def signals(self) -> dict[str, Signal]:
        if not any(self.there.get(topic) for topic in self.by_topic):
            wanted, has = ", ".join(filter(None, self.by_topic)), ", ".join(self.there) or "no topics"
            raise LogError(f"{self.path} has no messages on any of the topics {wanted}; it has {has}")
        parts: dict[str, list[Part]] = {}
        origin: dict[str, str] = {}
        for intake in self.intakes:
            entry = intake.entry
            try:
                found = intake.parts()
            except LogError as error:
                raise self._named(entry.topic, error) from error
            if found:
                parts.setdefault(entry.signal, []).extend(found)
                origin.setdefault(entry.signal, entry.topic)
            elif self.map.strict:
                self._say_absent(entry.topic, entry.field, entry.signal)
            if found and entry.role == "commanded" and not entry.signal.startswith("joint_command"):
                text = f"{entry.topic}: '{entry.signal}' is what was commanded, not measured"
                warnings.warn(text, LogWarning, stacklevel=2)
        signals = {}
        for name, pieces in parts.items():
            try:
                signal = checked(name, merged(name, pieces), origin[name])
            except LogError as error:
                raise self._named(origin[name], error) from error
            if signal is not None:
                signals[name] = signal
        return with_shared_times(signals)

    def _say_absent(self, topic: str, field: str, signal: str) -> None:
        text = f"'{field}' is empty in all messages" if self.there.get(topic) else "it has no messages"
        if signal == DRIVING or topic not in self.there:
            raise LogError(f"{self.path}, topic {topic}: {text}; the log has {', '.join(self.there) or 'no topics'}")
        warnings.warn(f"{topic}: {text}; '{signal}' is left out", LogWarning, stacklevel=2)

    def _check_type(self, channel: Channel, intakes: list[Intake]) -> None:
        for must in {intake.entry.type for intake in intakes} - {"", channel.type}:
            raise LogError(f"messages are {channel.type} in {channel.encoding}; must be {must} in cdr")

    def _named(self, topic: str, error: object) -> LogError:
        return LogError(f"{self.path}, topic {topic}: {error}")
