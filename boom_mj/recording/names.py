"""The signals that a boom's recording may hold: name -> unit, frame and channels. One row is one signal."""

from dataclasses import dataclass

LINKS = ("link2", "link3", "link4", "link5")
JOINTS = tuple(f"joint{k}" for k in range(1, 6))
XYZ = ("x", "y", "z")


@dataclass(frozen=True)
class SignalKind:
    unit: str
    frame: str
    channels: tuple[str, ...]


KINDS: dict[str, SignalKind] = {
    "joint/position": SignalKind("rad", "joint", JOINTS),
    "joint_command/position": SignalKind("rad", "joint", JOINTS),
    "joint_command/velocity": SignalKind("rad/s", "joint", JOINTS),
    **{f"imu/{link}/specific_force": SignalKind("m/s^2", f"{link}_tip", XYZ) for link in LINKS},
    **{f"imu/{link}/angular_rate": SignalKind("rad/s", f"{link}_tip", XYZ) for link in LINKS},
    "markers": SignalKind("m", "world", tuple(f"marker{k}/{axis}" for k in range(1, 13) for axis in XYZ)),
    "cylinder/force": SignalKind("N", "cylinder", ("cylinder2", "cylinder3")),
    "cylinder/length": SignalKind("m", "cylinder", ("cylinder2", "cylinder3")),
    "load": SignalKind("N", "world", XYZ),
}
