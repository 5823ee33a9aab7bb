"""Topic map: which topic and field of a log feeds which signal, with which names, signs, offsets and unit.

A signal's channel is `sign * logged + offset` (both in `unit`), turned into SI. docs/how-to/logs.md explains the file.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, FiniteFloat, ValidationError, field_validator, model_validator

from boom_mj.errors import TopicMapError, shown
from boom_mj.files import parse_toml, read_text
from boom_mj.logs.topics import LOGGED, TOPICS
from boom_mj.logs.units import GUESS, UNITS
from boom_mj.recording import QUANTITIES

HEADER, LOG = "header", "log"  # time bases
FIELDS = {"poses": "poses[].position", "force": "wrench.force"}  # of our own topics, as paths


class Entry(BaseModel):
    """What feeds one signal, or some of its channels.

    Attributes:
        signal: name of the signal, such as "joint/position".
        topic: of the log; "table" in a CSV file.
        field: path of the numbers in a message, such as "position", "wrench.force" or "poses[].position".
        source: `from` in the file: names of the numbers, in the order of `to`; empty for all of them, in order.
        to: channels of the signal; empty for all of them.
        sign: 1 or -1 per channel.
        offset: per channel, in `unit`.
        unit: of the logged numbers.
        role: whether the numbers were measured or commanded.
        time: "header" (stamp of the message), "log" (when it was recorded), or the path of a field with the time.
        time_unit: of that field.
        publisher: number of the channel, where several publish on the topic.
        constant: values of channels that the log lacks, instead of a topic and a field.
        type: message type that the topic must have; "" for any.
        frame: frame_id that its headers must have; "" for any.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", populate_by_name=True)

    signal: str
    unit: str
    topic: str = ""
    field: str = ""
    source: tuple[str, ...] = Field(default=(), alias="from")
    to: tuple[str, ...] = ()
    sign: tuple[Literal[1, -1], ...] = ()
    offset: tuple[FiniteFloat, ...] = ()
    role: Literal["measured", "commanded"] = "measured"
    time: str = HEADER
    time_unit: str = "s"
    publisher: int | None = None
    constant: tuple[FiniteFloat, ...] = ()
    type: str = ""
    frame: str = ""

    @field_validator("source", "to", "sign", "offset", "constant", mode="before")
    @classmethod
    def _one_is_a_list(cls, value: Any) -> Any:
        return tuple(value) if isinstance(value, (list, tuple)) else (value,)

    @model_validator(mode="after")
    def _fits(self) -> Self:
        if self.signal not in LOGGED:
            raise ValueError(f"signal = '{self.signal}' is unknown; the signals are {', '.join(LOGGED)}")
        quantity = QUANTITIES[self.signal]
        for key, unit, known in (("unit", self.unit, quantity.unit), ("time_unit", self.time_unit, "s")):
            choices = ", ".join(UNITS[known])
            if unit.endswith(GUESS):
                raise ValueError(f'{key} = "{unit}" is a guess: check it and take the question mark away ({choices})')
            if unit not in UNITS[known]:
                raise ValueError(f'{key} = "{unit}" is none of {choices}')
        if quantity.channels and (unknown := [name for name in self.to if name not in quantity.channels]):
            raise ValueError(f"to names {', '.join(unknown)}; channels are {', '.join(quantity.channels)}")
        if bool(self.constant) == bool(self.topic) or bool(self.topic) != bool(self.field):
            raise ValueError("it needs either a topic and a field, or a constant")
        if self.role == "measured" and self.signal.startswith("joint_command"):
            raise ValueError(f"'{self.signal}' is commanded, not measured: say role = \"commanded\"")
        for key, values in (("from", self.source), ("sign", self.sign), ("offset", self.offset)):
            if len(values) > 1 and self.channels and len(values) != len(self.channels):
                raise ValueError(f"{key} has {len(values)} entries for the channels {', '.join(self.channels)}")
        if self.constant and len(self.constant) != len(self.channels):
            raise ValueError(f"constant has {len(self.constant)} entries for the channels {', '.join(self.channels)}")
        return self

    @property
    def channels(self) -> tuple[str, ...]:
        """Channels of the signal that it feeds; empty where their number is free."""
        return self.to or QUANTITIES[self.signal].channels

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the numbers in the log; empty for all of them, in order."""
        if self.source or QUANTITIES[self.signal].points or len(self.to) == 1:
            return self.source
        return self.channels

    @property
    def factor(self) -> float:
        """Of the unit, to SI."""
        return UNITS[QUANTITIES[self.signal].unit][self.unit]


@dataclass(frozen=True)
class TopicMap:
    """Entries that belong together.

    Attributes:
        strict: every topic named must be in the log and carry what it is named for.
    """

    entries: tuple[Entry, ...]
    strict: bool = True


def load_topic_map(path: str | Path) -> TopicMap:
    """Read a topic map.

    Raises:
        TopicMapError: a file that is missing or no TOML, or every bad entry with its number and what is allowed.
    """
    document = parse_toml(read_text(path, TopicMapError), path, TopicMapError)
    rows = document.get("entry")
    if set(document) != {"entry"} or not isinstance(rows, list) or not all(isinstance(row, dict) for row in rows):
        raise TopicMapError(
            f"{path}: a topic map holds [[entry]] tables; this one holds {', '.join(document) or 'nothing'}"
        )
    entries, wrong = [], []
    for number, row in enumerate(rows, 1):
        try:
            entries.append(Entry(**row))
        except ValidationError as error:
            wrong += [f"{path}, entry {number}: {_sentence(item)}" for item in error.errors()]
    if wrong:
        raise TopicMapError("\n".join(wrong))
    return TopicMap(tuple(entries))


def _sentence(item: Any) -> str:
    place, kind = ".".join(map(str, item["loc"])), item["type"]
    if kind == "missing":
        return f"{place} is missing"
    if kind == "extra_forbidden":
        known = ", ".join(field.alias or name for name, field in Entry.model_fields.items())
        return f"{place} is an unknown key; known are {known}"
    message = item["msg"].removeprefix("Value error, ")
    return f"{place} = {shown(item['input'])}: {message}" if place else message


def own_map() -> TopicMap:
    """The map of the logs that this package writes."""
    return TopicMap(
        tuple(
            Entry(
                signal=signal,
                topic=topic.name,
                field=FIELDS.get(field, field),
                unit=QUANTITIES[signal].unit,
                role="commanded" if signal.startswith("joint_command") else "measured",
                type=topic.kind.ros_type,
                frame="" if topic.accepts("") else topic.frame_id,
            )
            for topic in TOPICS
            for field, signal in topic.signals.items()
        ),
        strict=False,
    )
