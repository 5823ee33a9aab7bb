"""How a ROS 2 message carries samples: one small function per message type makes it from one row per field.

A row holds the channels of one signal at one time, (k,). Definitions and CDR come from rosbags.
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
    """

    ros_type: str
    pack: Callable[[Any, Names, Rows, Mapping[str, float]], Any]


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


def _pack_imu(header: Any, names: Names, rows: Rows, variance: Mapping[str, float]) -> Any:
    fields: dict[str, Any] = {"orientation": _upright(), "orientation_covariance": _covariance(NOT_MEASURED, 1)}
    for field in ("angular_velocity", "linear_acceleration"):
        known = field in rows
        fields[field] = make("geometry_msgs/msg/Vector3", *rows.get(field, np.zeros(3)))
        fields[f"{field}_covariance"] = (
            _covariance(variance.get(field, 0.0), 3) if known else _covariance(NOT_MEASURED, 1)
        )
    return make(IMU.ros_type, header=header, **fields)


def _pack_poses(header: Any, names: Names, rows: Rows, variance: Mapping[str, float]) -> Any:
    points = (make("geometry_msgs/msg/Point", *point) for point in rows["poses"].reshape(-1, 3))
    poses = [make("geometry_msgs/msg/Pose", position=point, orientation=_upright()) for point in points]
    return make(POSE_ARRAY.ros_type, header=header, poses=poses)


def _pack_wrench(header: Any, names: Names, rows: Rows, variance: Mapping[str, float]) -> Any:
    force = make("geometry_msgs/msg/Vector3", *rows["force"])
    torque = make("geometry_msgs/msg/Vector3", 0.0, 0.0, 0.0)
    return make(WRENCH.ros_type, header=header, wrench=make("geometry_msgs/msg/Wrench", force=force, torque=torque))


def _upright() -> Any:
    return make("geometry_msgs/msg/Quaternion", 0.0, 0.0, 0.0, 1.0)


@cache
def _covariance(variance: float, axes: int) -> Array:
    """Diagonal 3 x 3 covariance, row major, with the variance on the first `axes` axes; shared."""
    found = np.diag([variance if i < axes else 0.0 for i in range(3)]).ravel()
    found.flags.writeable = False
    return found


JOINT_STATE = MessageKind("sensor_msgs/msg/JointState", _pack_joint_state)
IMU = MessageKind("sensor_msgs/msg/Imu", _pack_imu)
POSE_ARRAY = MessageKind("geometry_msgs/msg/PoseArray", _pack_poses)
WRENCH = MessageKind("geometry_msgs/msg/WrenchStamped", _pack_wrench)
