"""A recording: named signals of one experiment on one machine."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any

from boom_mj.errors import LogError
from boom_mj.recording.names import check_quantity
from boom_mj.recording.signal import Signal


@dataclass(frozen=True, eq=False)
class Recording:
    """Signals of one experiment, measured or simulated; `recording["joint/position"]` gives one of them.

    Attributes:
        name: experiment, such as "release_stretched_vertical".
        machine: name of the machine.
        description: one sentence on what happened.
        signals: by name; those of `QUANTITIES` have its units, frames and channels. Each has its own times.
    """

    name: str
    machine: str
    description: str
    signals: Mapping[str, Signal]

    def __post_init__(self) -> None:
        for name, signal in self.signals.items():
            check_quantity(name, signal)
        object.__setattr__(self, "signals", MappingProxyType(dict(self.signals)))

    def __getitem__(self, name: str) -> Signal:
        if name not in self.signals:
            there = ", ".join(self.signals) or "no signals at all"
            raise LogError(f"recording '{self.name}' has no signal '{name}'; it has {there}")
        return self.signals[name]

    def __contains__(self, name: object) -> bool:
        return name in self.signals

    def __reduce__(self) -> tuple[Any, ...]:  # a mapping proxy alone cannot travel to another process
        return Recording, (self.name, self.machine, self.description, dict(self.signals))

    @property
    def duration(self) -> float:
        """From the first sample of any signal to the last of any, s; 0 without signals."""
        times = [signal.time for signal in self.signals.values()]
        return float(max(t[-1] for t in times) - min(t[0] for t in times)) if times else 0.0

    def with_signals(self, signals: Mapping[str, Signal]) -> "Recording":
        """The same recording with signals added or replaced."""
        return replace(self, signals={**self.signals, **signals})
