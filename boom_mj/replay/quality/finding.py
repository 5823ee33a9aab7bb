"""What is wrong with the data: one record a finding, and the entry of a topic map that would mend it."""

from dataclasses import asdict, dataclass
from enum import StrEnum
from typing import Any


class Action(StrEnum):
    """What was done about a finding."""

    LEFT_OUT = "left out"
    CENSORED = "censored"
    NOISE_RAISED = "noise raised"
    REPAIRED = "repaired"
    SAID = "said"
    REFUSED = "refused"


@dataclass(frozen=True)
class Repair:
    """What the topic map must say of a signal, or of one of its channels, for the log to read well.

    Attributes:
        signal: name of the signal.
        channel: the one channel concerned; "" for all of them.
        unit: of the logged numbers.
        sign: 1 or -1.
        offset: to add, in the signal's SI unit.
        source: sensor, or channel of this signal, whose topic or name in the log must feed it instead of its own.
    """

    signal: str
    channel: str = ""
    unit: str = ""
    sign: int = 1
    offset: float = 0.0
    source: str = ""

    @property
    def line(self) -> str:
        """The keys of the entry, in short."""
        keys = [f'unit = "{self.unit}"'] if self.unit else []
        keys += [f"sign = {self.sign}"] if self.sign != 1 else []
        keys += [f"offset = {self.offset:.6g}"] if self.offset else []
        keys += [f"the topic, or the name, of {self.source}"] if self.source else []
        place = f'signal = "{self.signal}"' + (f', to = "{self.channel}"' if self.channel else "")
        return f"{place}: {', '.join(keys)}"


@dataclass(frozen=True)
class DataFinding:
    """Something wrong with the data.

    Attributes:
        log: its name.
        channel: signal and channel, such as "imu/link4/specific_force/y"; a signal or sensor where all of it is meant,
            "" where the log is.
        kind: word for what it is, the same for all of its kind.
        from_s, to_s: where, s from the first stamp of the log's joint angles.
        evidence: sentence with the numbers.
        action: what was done.
        used: whether what is named is still used.
        repair: what a topic map would have to say.
    """

    log: str
    channel: str
    kind: str
    from_s: float
    to_s: float
    evidence: str
    action: Action
    used: bool
    repair: Repair | None = None

    @property
    def sentence(self) -> str:
        """All of it in one."""
        return f"{self.log}: {self.channel or 'the log'} {self.evidence}: {self.action}"

    def document(self) -> dict[str, Any]:
        """As the answer of a diagnosis holds it."""
        found = {**asdict(self), "action": str(self.action), "finding": self.sentence}
        return {**found, "repair": self.repair.line if self.repair else None}
