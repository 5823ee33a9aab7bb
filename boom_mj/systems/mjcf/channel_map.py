"""Channel map: which field of a log is which joint, actuator or sensor of an MJCF file, and how logs are cut.

A channel's value in SI is `scale * logged + offset`; docs/how-to/own_machine.md explains the file.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, FiniteFloat, ValidationError, model_validator

from boom_mj.errors import ChannelMapError, shown
from boom_mj.files import parse_toml, read_text
from boom_mj.logs.columns import CLOCKS
from boom_mj.machine.fields import NonNegative, Positive

Role = Literal["drive", "control", "compare", "temperature"]
Quantity = Literal["position", "velocity", "force", "command", "sensor", "temperature"]


class ChannelEntry(BaseModel):
    """One channel.

    Attributes:
        name: as the answer calls it.
        role: "drive": measured motion that a joint is made to follow; "control": command of an actuator; "compare":
            what the model must say; "temperature": what laws may depend on.
        joint, actuator, sensor: what it belongs to in the MJCF file, just one of them; of a temperature a joint, or
            nothing where it is the whole machine's.
        component: of the sensor.
        field: of the log.
        terms: instead of a field, a sum of fields by their factors.
        time: field of its time, where that is not the map's; see `ChannelMap.clock`.
        scale, offset: to SI.
        unit: of the result.
        relative: what counts is the difference to the value when a stretch begins.
        limit: the logged size (before scale and offset) is cut there, as the machine's amplifier does.
        wrap: period by which what is logged jumps, as a potentiometer's does after a turn; jumps are undone.
        noise: standard deviation of a sample in SI; at least what the log itself shows counts.
        zero: standard deviation of a zero offset that is nobody's fault, in SI.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    name: str
    role: Role
    joint: str = ""
    actuator: str = ""
    sensor: str = ""
    quantity: Quantity | None = None
    component: int = Field(default=0, ge=0)
    field: str = ""
    terms: Mapping[str, FiniteFloat] = {}
    time: str = ""
    scale: FiniteFloat = 1.0
    offset: FiniteFloat = 0.0
    unit: str = ""
    relative: bool = False
    limit: Positive | None = None
    wrap: Positive | None = None
    noise: NonNegative = 0.0
    zero: NonNegative = 0.0

    @model_validator(mode="after")
    def _fits(self) -> Self:
        if self.role == "temperature":
            if self.actuator or self.sensor:
                raise ValueError(f"channel '{self.name}' is a temperature: it may name a joint, nothing else")
        elif sum(map(bool, (self.joint, self.actuator, self.sensor))) != 1:
            raise ValueError(f"channel '{self.name}' needs just one of joint, actuator and sensor")
        if bool(self.field) == bool(self.terms):
            raise ValueError(f"channel '{self.name}' needs either a field or terms")
        if self.role == "drive" and not self.joint:
            raise ValueError(f"channel '{self.name}' drives: it must name a joint")
        if self.role == "control" and not self.actuator:
            raise ValueError(f"channel '{self.name}' controls: it must name an actuator")
        if self.what not in self.allowed:
            raise ValueError(
                f"channel '{self.name}': quantity = '{self.what}' is none of {', '.join(self.allowed)} for its role"
            )
        return self

    @property
    def allowed(self) -> tuple[str, ...]:
        """Quantities that go with the role and the place."""
        of_role = {"drive": "position", "control": "command", "temperature": "temperature"}
        if self.role in of_role:
            return (of_role[self.role],)
        return ("sensor",) if self.sensor else ("force",) if self.actuator else ("position", "velocity")

    @property
    def what(self) -> str:
        return self.quantity or self.allowed[0]

    @property
    def fields(self) -> tuple[str, ...]:
        return (self.field,) if self.field else tuple(self.terms)

    @property
    def sensed(self) -> bool:
        """Whether it is a reading that the model follows or must predict."""
        return self.role in ("drive", "compare")

    @property
    def place(self) -> str:
        return self.joint or self.actuator or self.sensor


class Release(BaseModel):
    """A log begins when something that was held lets go: a field leaves its value, as a falling body does.

    Attributes:
        field: that tells.
        moves: by how much, in the log's own unit; the moment is where the root of its way, traced back, is zero.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    field: str
    moves: Positive


class LogEntry(BaseModel):
    """What is known of one log.

    Attributes:
        file: its name, or the end of its path, such as `loaded/state.csv`.
        start, stop: s, instead of the map's.
        set: numbers of the MJCF file in this log: a load that was told, another gain; see `with_settings`.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    file: str
    start: NonNegative | None = None
    stop: Positive | None = None
    set: Mapping[str, FiniteFloat | tuple[FiniteFloat, ...]] = {}


class ChannelMap(BaseModel):
    """A machine's channels and how its logs are cut.

    Attributes:
        name: of the machine.
        time: field of the time; `time_scale` turns it into s.
        model: MJCF file, relative to the map; the command line may name another.
        block: over which channels are averaged, s; a period of the cutoff if left out.
        window: length of the stretches that are simulated afresh, s.
        settle: how long before a stretch its simulation begins, s: of the log's beginning nothing is compared so long.
        cutoff: of the zero-phase filter that makes driving motion smooth, Hz.
        release: what tells that something was let go; what comes before is left out.
        stop: what comes later is left out, s.
        repeat: period of a motion that the logs repeat, s: what differs between passes counts as noise, what does not
            is one and the same error of the model in all of them.
        independent: beyond which residuals count as independent, s.
        train: share of a log, from its start, to learn from where no other logs are held out.
        causes: most effects that an explanation may have.
        log: what is known of single logs.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    name: str
    time: str
    time_scale: Positive = 1.0
    model: str = ""
    block: Positive | None = None
    window: Positive = 10.0
    settle: NonNegative = 0.0
    cutoff: Positive = 10.0
    start: NonNegative = 0.0
    stop: Positive | None = None
    release: Release | None = None
    repeat: Positive | None = None
    independent: Positive = 1.0
    train: float = Field(default=0.6, gt=0, lt=1)
    causes: int = Field(default=6, ge=1, le=8)
    channel: tuple[ChannelEntry, ...]
    log: tuple[LogEntry, ...] = ()

    @model_validator(mode="after")
    def _fits(self) -> Self:
        names = [entry.name for entry in self.channel]
        if twice := sorted({name for name in names if names.count(name) > 1}):
            raise ValueError(f"several channels are called {', '.join(twice)}")
        warm = [entry.joint for entry in self.role("temperature")]
        if twice := sorted({joint or "the machine" for joint in warm if warm.count(joint) > 1}):
            raise ValueError(f"several channels are the temperature of {', '.join(twice)}")
        if not self.role("compare"):
            raise ValueError('no channel has role = "compare": there is nothing to judge by')
        return self

    def of_log(self, path: Path | str) -> "LogEntry":
        """What is known of a log; an entry without anything where nothing is."""
        parts = Path(path).parts
        entries = (entry for entry in self.log if parts[-len(Path(entry.file).parts) :] == Path(entry.file).parts)
        return next(entries, LogEntry(file=Path(path).name))

    def clock(self, entry: ChannelEntry) -> str:
        """Field of a channel's time: its own, the map's, or as that is of a topic its own topic's."""
        topic, _, of = self.time.partition(".")
        own = entry.fields[0].partition(".")[0]
        other = topic.startswith("/") and own.startswith("/") and of in CLOCKS
        return entry.time or (f"{own}.{of}" if other else self.time)

    def role(self, role: Role) -> tuple[ChannelEntry, ...]:
        """The channels of a role."""
        return tuple(entry for entry in self.channel if entry.role == role)

    def temperature(self, joint: str) -> ChannelEntry | None:
        """That of a joint, or of the machine; None where neither is logged."""
        own = {entry.joint: entry for entry in self.role("temperature")}
        return own.get(joint) or own.get("")

    @property
    def block_s(self) -> float:
        """Over which channels are averaged, s."""
        return self.block if self.block is not None else 1 / self.cutoff

    @property
    def compared_cutoff(self) -> float:
        """Of what is compared where motion drives, Hz."""
        return self.cutoff / 2

    @property
    def driven(self) -> tuple[str, ...]:
        """Joints that follow their measured motion."""
        return tuple(entry.joint for entry in self.role("drive"))

    @property
    def started(self) -> tuple[str, ...]:
        """Joints that a stretch begins with as they were measured."""
        compared = {entry.joint for entry in self.role("compare") if entry.joint and entry.what == "position"}
        return tuple(sorted(compared - set(self.driven)))


def load_channel_map(path: Path) -> ChannelMap:
    """Read a channel map.

    Raises:
        ChannelMapError: no such file, no TOML, or entries that are wrong; all of them are named.
    """
    return parse_channel_map(read_text(path, ChannelMapError), str(path))


def parse_channel_map(text: str, name: str = "channel map") -> ChannelMap:
    """A channel map from its text; see `load_channel_map`."""
    content = parse_toml(text, name, ChannelMapError)
    try:
        return ChannelMap.model_validate(content)
    except ValidationError as error:
        raise ChannelMapError("\n".join(f"{name}: {_sentence(item)}" for item in error.errors())) from error


def _sentence(item: Any) -> str:
    place, kind = ".".join(map(str, item["loc"])), item["type"]
    if kind == "missing":
        return f"{place} is missing"
    if kind == "extra_forbidden":
        of_tables: dict[str, type[BaseModel]] = {"channel": ChannelEntry, "log": LogEntry}
        kinds = of_tables.get(place.partition(".")[0] if "." in place else "", ChannelMap)
        return f"{place} is an unknown key; known are {', '.join(kinds.model_fields)}"
    message = item["msg"].removeprefix("Value error, ")
    return f"{place} = {shown(item['input'])}: {message}" if place and kind != "value_error" else message
