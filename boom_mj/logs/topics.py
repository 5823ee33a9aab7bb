"""Which topic carries which signals: one row per topic, the message's layout in two small functions.

Messages are the classes that rosbags makes of ROS 2's own definitions (Humble).
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from rosbags.typesys import Stores, get_typestore

from boom_mj.errors import LogError
from boom_mj.recording.names import JOINTS, LINKS

Array = np.ndarray
STORE = get_typestore(Stores.ROS2_HUMBLE)
TYPES = STORE.types
CYLINDERS = ("cylinder2", "cylinder3")


@dataclass(frozen=True)
class Topic:
    """A topic: its message type and how rows of signals become messages and back.

    Attributes:
        type: ROS 2 message type.
        frame: of the header.
        signals: names of the signals that it carries; those it cannot do without come first.
        write: (header, row per signal) -> message.
        read: message -> row per signal, None for a signal that the message lacks.
    """

    type: str
    frame: str
    signals: tuple[str, ...]
    write: Callable[[Any, Mapping[str, Array]], Any]
    read: Callable[[Any], Mapping[str, Array | None]]


def header(seconds: int, nanoseconds: int, frame: str) -> Any:
    stamp = TYPES["builtin_interfaces/msg/Time"](sec=seconds, nanosec=nanoseconds)
    return TYPES["std_msgs/msg/Header"](stamp=stamp, frame_id=frame)


def _joint_state(names: tuple[str, ...], **fields: str) -> dict[str, Any]:
    """Layout of a JointState whose fields (position, velocity, effort) hold signals."""

    def write(head: Any, rows: Mapping[str, Array]) -> Any:
        values = {field: np.asarray(rows.get(signal, np.zeros(0))) for field, signal in fields.items()}
        empty = {field: np.zeros(0) for field in ("position", "velocity", "effort")}
        return TYPES["sensor_msgs/msg/JointState"](header=head, name=list(names), **{**empty, **values})

    def read(message: Any) -> Mapping[str, Array | None]:
        missing = [name for name in names if name not in message.name]
        if missing:
            raise LogError(f"joint {missing[0]} is missing; the message names {', '.join(message.name) or 'none'}")
        order = [list(message.name).index(name) for name in names]
        found = {}
        for field, signal in fields.items():
            values = np.asarray(getattr(message, field))
            found[signal] = values[order] if values.size == len(message.name) else None
        return found

    return {"type": "sensor_msgs/msg/JointState", "write": write, "read": read}


def _vector(row: Array) -> Any:
    return TYPES["geometry_msgs/msg/Vector3"](x=float(row[0]), y=float(row[1]), z=float(row[2]))


def _xyz(vector: Any) -> Array:
    return np.array([vector.x, vector.y, vector.z])


def _imu(link: str) -> Topic:
    force, rate = f"imu/{link}/specific_force", f"imu/{link}/angular_rate"
    unknown = np.array([-1.0, *[0.0] * 8])  # REP 145: no orientation in this message

    def write(head: Any, rows: Mapping[str, Array]) -> Any:
        return TYPES["sensor_msgs/msg/Imu"](
            header=head,
            orientation=TYPES["geometry_msgs/msg/Quaternion"](x=0.0, y=0.0, z=0.0, w=1.0),
            orientation_covariance=unknown,
            angular_velocity=_vector(rows[rate]),
            angular_velocity_covariance=np.zeros(9),
            linear_acceleration=_vector(rows[force]),
            linear_acceleration_covariance=np.zeros(9),
        )

    def read(message: Any) -> Mapping[str, Array | None]:
        return {force: _xyz(message.linear_acceleration), rate: _xyz(message.angular_velocity)}

    return Topic("sensor_msgs/msg/Imu", f"{link}_tip", (force, rate), write, read)


def _markers(head: Any, rows: Mapping[str, Array]) -> Any:
    point, pose = TYPES["geometry_msgs/msg/Point"], TYPES["geometry_msgs/msg/Pose"]
    level = TYPES["geometry_msgs/msg/Quaternion"](x=0.0, y=0.0, z=0.0, w=1.0)
    places = np.asarray(rows["markers"], float).reshape(-1, 3).tolist()
    poses = [pose(position=point(x=x, y=y, z=z), orientation=level) for x, y, z in places]
    return TYPES["geometry_msgs/msg/PoseArray"](header=head, poses=poses)


def _read_markers(message: Any) -> Mapping[str, Array | None]:
    if len(message.poses) != 12:
        raise LogError(f"{len(message.poses)} markers where 12 are expected, three on each of {', '.join(LINKS)}")
    return {"markers": np.concatenate([_xyz(pose.position) for pose in message.poses])}


def _load(head: Any, rows: Mapping[str, Array]) -> Any:
    wrench = TYPES["geometry_msgs/msg/Wrench"](force=_vector(rows["load"]), torque=_vector(np.zeros(3)))
    return TYPES["geometry_msgs/msg/WrenchStamped"](header=head, wrench=wrench)


COMMAND = {"position": "joint_command/position", "velocity": "joint_command/velocity"}
CYLINDER = {"effort": "cylinder/force", "position": "cylinder/length"}
TOPICS: Mapping[str, Topic] = {
    "/joint_states": Topic(
        frame="base", signals=("joint/position",), **_joint_state(JOINTS, position="joint/position")
    ),
    "/joint_command": Topic(frame="base", signals=tuple(COMMAND.values()), **_joint_state(JOINTS, **COMMAND)),
    **{f"/imu/{link}": _imu(link) for link in LINKS},
    "/markers": Topic("geometry_msgs/msg/PoseArray", "world", ("markers",), _markers, _read_markers),
    "/cylinder_states": Topic(frame="base", signals=tuple(CYLINDER.values()), **_joint_state(CYLINDERS, **CYLINDER)),
    "/load": Topic(
        "geometry_msgs/msg/WrenchStamped", "world", ("load",), _load, lambda m: {"load": _xyz(m.wrench.force)}
    ),
}
