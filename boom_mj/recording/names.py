"""The signals a recording knows by name: unit, frame and channels, in one table."""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from boom_mj.errors import LogError
from boom_mj.recording.signal import Signal

JOINTS = tuple(f"joint{i}" for i in range(1, 6))
CYLINDERS = ("cylinder2", "cylinder3")
FLEXIBLE_LINKS = (2, 3, 4, 5)
AXES = ("x", "y", "z")


def point_channels(prefix: str, count: int) -> tuple[str, ...]:
    """Channel names of a row of points: marker1/x, marker1/y, marker1/z, marker2/x, ..."""
    return tuple(f"{prefix}{i}/{axis}" for i in range(1, count + 1) for axis in AXES)


@dataclass(frozen=True)
class Quantity:
    """What a named signal is.

    Attributes:
        channels: names of its channels; empty where their number is free.
        points: for points in space, the prefix of their names: points may be hidden (NaN).
    """

    unit: str
    frame: str
    channels: tuple[str, ...]
    points: str | None = None

    def channels_of(self, width: int) -> tuple[str, ...]:
        """Channel names for values with `width` columns."""
        return self.channels or point_channels(self.points or "", width // len(AXES))


QUANTITIES: Mapping[str, Quantity] = MappingProxyType(
    {
        "joint/position": Quantity("rad", "joint", JOINTS),
        "joint_command/position": Quantity("rad", "joint", JOINTS),
        "joint_command/velocity": Quantity("rad/s", "joint", JOINTS),
        **{f"imu/link{i}/specific_force": Quantity("m/s^2", f"link{i}_tip", AXES) for i in FLEXIBLE_LINKS},
        **{f"imu/link{i}/angular_rate": Quantity("rad/s", f"link{i}_tip", AXES) for i in FLEXIBLE_LINKS},
        "markers": Quantity("m", "world", point_channels("marker", 12), points="marker"),
        "markers/truck": Quantity("m", "world", (), points="truck"),
        "cylinder/force": Quantity("N", "cylinder", CYLINDERS),
        "cylinder/length": Quantity("m", "cylinder", CYLINDERS),
        "load": Quantity("N", "world", AXES),
    }
)
"""What every signal that has a name is."""


def named_signal(name: str, time: np.ndarray, values: np.ndarray) -> Signal:
    """Signal with the unit, frame and channels that its name stands for.

    Args:
        time: (n,), s.
        values: (n, k) in the unit and frame of `QUANTITIES[name]`.
    """
    if name not in QUANTITIES:
        raise LogError(f"there is no signal called '{name}'; the names are {', '.join(QUANTITIES)}")
    quantity = QUANTITIES[name]
    return Signal(time, values, quantity.channels_of(np.shape(values)[-1]), quantity.unit, quantity.frame)


def check_quantity(name: str, signal: Signal) -> None:
    """Refuse a signal under a known name that it does not fit; other names are free."""
    if name not in QUANTITIES:
        return
    quantity = QUANTITIES[name]
    expected = (quantity.unit, quantity.frame, quantity.channels_of(len(signal.channels)))
    for what, is_, must in zip(("unit", "frame", "channels"), (signal.unit, signal.frame, signal.channels), expected):
        if is_ != must:
            raise LogError(f"signal '{name}' has {what} {is_}; it must be {must}")
