"""How a ROS 2 message carries samples: one pair of small functions per message type.

`pack` makes a message from one row per field; `unpack` gives the row of a field back, None where the message
says that it has none, and a ValueError on a message that is not what its type promises. A row holds the
channels of one signal at one time, (k,). Definitions and CDR come from rosbags.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from rosbags.typesys import Stores, get_typestore
from rosbags.typesys.store import Typestore

Array = np.ndarray
Rows = Mapping[str, Array]
Names = tuple[str, ...]

NOT_MEASURED = -1.0  # first entry of a covariance, by the convention of sensor_msgs/Imu


@dataclass(frozen=True)
class MessageKind:
    """One ROS message type.

    Attributes:
        ros_type: full name, such as "sensor_msgs/msg/Imu".
        pack: (header, channel names, row by field, noise variance by field) -> message.
        unpack: (message, field, channel names) -> row, or None where absent.
    """

    ros_type: str
    pack: Callable[[Any, Names, Rows, Mapping[str, float]], Any]
    unpack: Callable[[Any, str, Names], Array | None]


@cache
def typestore() -> Typestore:
    """Message definitions and CDR of ROS 2; the types used here are the same in every distribution."""
    return get_typestore(Stores.ROS2_HUMBLE)


def make(ros_type: str, *args: Any, **kwargs: Any) -> Any:
    """Message of a type."""
    return typestore().types[ros_type](*args, **kwargs)


def _pack_joint_state(header: Any, names: Names, rows: Rows, variance: Mapping[str, float]) -> Any:
    fields = {field: rows.get(field, np.empty(0)) for field in ("position", "velocity", "effort")}
    return make(JOINT_STATE.ros_type, header=header, name=list(names), **fields)


def _unpack_joint_state(message: Any, field: str, names: Names) -> Array | None:
    values = getattr(message, field)
    if values.size == 0:
        return None
    if values.size != len(message.name):
        raise ValueError(f"{values.size} values of {field} for the {len(message.name)} names {message.name}")
    return values[_order(tuple(message.name), names)]


@cache
def _order(present: Names, wanted: Names) -> Array:
    """Where the wanted names stand among those present; further ones are left aside."""
    if missing := [name for name in wanted if present.count(name) != 1]:
        raise ValueError(f"{', '.join(missing)} missing or double; present are {', '.join(present)}")
    return np.array([present.index(name) for name in wanted])


def _pack_imu(header: Any, names: Names, rows: Rows, variance: Mapping[str, float]) -> Any:
    fields: dict[str, Any] = {"orientation": _upright(), "orientation_covariance": _covariance(NOT_MEASURED, 1)}
    for field in ("angular_velocity", "linear_acceleration"):
        known = field in rows
        fields[field] = make("geometry_msgs/msg/Vector3", *rows.get(field, np.zeros(3)))
        fields[f"{field}_covariance"] = (
            _covariance(variance.get(field, 0.0), 3) if known else _covariance(NOT_MEASURED, 1)
        )
    return make(IMU.ros_type, header=header, **fields)


def _unpack_imu(message: Any, field: str, names: Names) -> Array | None:
    absent = getattr(message, f"{field}_covariance")[0] == NOT_MEASURED
    return None if absent else _vector(getattr(message, field))


def _pack_poses(header: Any, names: Names, rows: Rows, variance: Mapping[str, float]) -> Any:
    points = (make("geometry_msgs/msg/Point", *point) for point in rows["poses"].reshape(-1, 3))
    poses = [make("geometry_msgs/msg/Pose", position=point, orientation=_upright()) for point in points]
    return make(POSE_ARRAY.ros_type, header=header, poses=poses)


def _unpack_poses(message: Any, field: str, names: Names) -> Array | None:
    row = np.array([(p.position.x, p.position.y, p.position.z) for p in message.poses]).ravel()
    if names and row.size != len(names):
        raise ValueError(f"{row.size // 3} poses instead of {len(names) // 3}")
    return row if row.size else None


def _pack_wrench(header: Any, names: Names, rows: Rows, variance: Mapping[str, float]) -> Any:
    force = make("geometry_msgs/msg/Vector3", *rows["force"])
    torque = make("geometry_msgs/msg/Vector3", 0.0, 0.0, 0.0)
    return make(WRENCH.ros_type, header=header, wrench=make("geometry_msgs/msg/Wrench", force=force, torque=torque))


def _unpack_wrench(message: Any, field: str, names: Names) -> Array | None:
    return _vector(getattr(message.wrench, field))


def _vector(vector: Any) -> Array:
    return np.array([vector.x, vector.y, vector.z])


def _upright() -> Any:
    return make("geometry_msgs/msg/Quaternion", 0.0, 0.0, 0.0, 1.0)


def _covariance(variance: float, axes: int) -> Array:
    """Diagonal 3 x 3 covariance, row major, with the variance on the first `axes` axes."""
    return np.diag([variance if i < axes else 0.0 for i in range(3)]).ravel()


JOINT_STATE = MessageKind("sensor_msgs/msg/JointState", _pack_joint_state, _unpack_joint_state)
IMU = MessageKind("sensor_msgs/msg/Imu", _pack_imu, _unpack_imu)
POSE_ARRAY = MessageKind("geometry_msgs/msg/PoseArray", _pack_poses, _unpack_poses)
WRENCH = MessageKind("geometry_msgs/msg/WrenchStamped", _pack_wrench, _unpack_wrench)
