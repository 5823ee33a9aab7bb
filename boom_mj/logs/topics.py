"""Which topic carries which signals: the one table that reading and writing share."""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from boom_mj.errors import LogError
from boom_mj.logs.messages import IMU, JOINT_STATE, POSE_ARRAY, WRENCH, MessageKind
from boom_mj.recording import QUANTITIES, Signal

METADATA = "experiment"  # record with name, machine and description


@dataclass(frozen=True)
class Topic:
    """One topic of a log.

    Attributes:
        name: such as "/imu/link2".
        kind: its message type.
        frame_id: of its headers.
        signals: message field -> signal name; the signals of one topic share their times.
    """

    name: str
    kind: MessageKind
    frame_id: str
    signals: Mapping[str, str]

    @property
    def channels(self) -> tuple[str, ...]:
        """Channel names of its signals; empty where their number is free."""
        return QUANTITIES[next(iter(self.signals.values()))].channels

    def accepts(self, frame_id: str) -> bool:
        """Whether a header may say so; vectors and points need their frame, a joint angle has none."""
        return self.kind is JOINT_STATE or frame_id == self.frame_id


TOPICS = (
    Topic("/joint_states", JOINT_STATE, "base", {"position": "joint/position"}),
    Topic(
        "/joint_command",
        JOINT_STATE,
        "base",
        {"position": "joint_command/position", "velocity": "joint_command/velocity"},
    ),
    *(
        Topic(
            f"/imu/{link}",
            IMU,
            f"{link}_tip",
            {"linear_acceleration": f"imu/{link}/specific_force", "angular_velocity": f"imu/{link}/angular_rate"},
        )
        for link in ("link2", "link3", "link4", "link5")
    ),
    Topic("/markers", POSE_ARRAY, "world", {"poses": "markers"}),
    Topic("/markers/truck", POSE_ARRAY, "world", {"poses": "markers/truck"}),
    Topic("/cylinder_states", JOINT_STATE, "base", {"effort": "cylinder/force", "position": "cylinder/length"}),
    Topic("/load", WRENCH, "world", {"force": "load"}),
)
TOPIC_NAMED: Mapping[str, Topic] = MappingProxyType({topic.name: topic for topic in TOPICS})
LOGGED = tuple(signal for topic in TOPICS for signal in topic.signals.values())


def refuse_gaps(name: str, signal: Signal) -> None:
    """Refuse NaN in a log, except for points, which may be hidden."""
    missing = np.argwhere(np.isnan(signal.values))
    if missing.size and QUANTITIES[name].points is None:
        i, j = missing[0]
        raise LogError(f"{signal.channels[j]} of '{name}' is NaN at {signal.time[i]:.3f} s; only markers may be hidden")
