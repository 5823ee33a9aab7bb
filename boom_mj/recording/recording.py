"""Recordings: the signals of one run of a machine, real or simulated."""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from boom_mj.errors import LogError
from boom_mj.recording.names import KINDS
from boom_mj.recording.signal import Array, Signal


@dataclass(frozen=True)
class Recording:
    """Signals by name (see `names.KINDS`), with what the run was.

    Attributes:
        name: of the experiment.
        machine: name of the machine.
        description: one sentence.
        signals: name to signal.
    """

    name: str
    machine: str
    description: str
    signals: Mapping[str, Signal]

    def __post_init__(self) -> None:
        object.__setattr__(self, "signals", MappingProxyType(dict(self.signals)))

    def __getitem__(self, name: str) -> Signal:
        try:
            return self.signals[name]
        except KeyError:
            held = ", ".join(self.signals) or "nothing"
            raise LogError(f"recording {self.name!r} has no signal {name!r}; it holds: {held}") from None

    def __contains__(self, name: str) -> bool:
        return name in self.signals

    @property
    def duration(self) -> float:
        """From the first sample of any signal to the last, s."""
        spans = [(s.time[0], s.time[-1]) for s in self.signals.values() if len(s.time)]
        return max(stop for _, stop in spans) - min(start for start, _ in spans) if spans else 0.0


def signal_of_kind(name: str, time: Array, values: Array) -> Signal:
    """A signal with the unit, frame and channels that its name stands for."""
    kind = KINDS[name]
    return Signal(time, values.reshape(len(time), -1), kind.channels, kind.unit, kind.frame)
