"""Logs as other programs write them, with the same joint angles in each."""

import gzip
import json
from collections.abc import Iterable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from google.protobuf import descriptor_pb2, descriptor_pool, message_factory, timestamp_pb2
from mcap.writer import Writer
from rosbags.rosbag1 import Writer as Ros1Writer
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as Ros2Writer
from rosbags.typesys import Stores, get_typestore

from boom_mj.logs import load_topic_map, read_log
from boom_mj.logs.inspection import inspect_log
from boom_mj.logs.messages import make, typestore
from boom_mj.logs.proposal import propose_map
from boom_mj.logs.topic_map import Entry, TopicMap
from boom_mj.recording import Recording

JOINTS = ("joint1", "joint2", "joint3", "joint4", "joint5")
RATE = 50.0  # Hz
START = 1_700_000_000.0  # s, as clocks on machines tell it
TIME = START + np.arange(101) / RATE
ANGLES = 0.3 * np.sin(np.outer(TIME - START, np.arange(1.0, 6.0))) + np.arange(5) / 10  # (101, 5), rad
Message = tuple[int, bytes]  # log time in ns, content

IDL = """\
================================================================================
IDL: sensor_msgs/msg/JointState
module sensor_msgs { module msg { struct JointState {
  std_msgs::msg::Header header; sequence<string> name;
  sequence<double> position; sequence<double> velocity; sequence<double> effort; }; }; };
================================================================================
IDL: std_msgs/msg/Header
module std_msgs { module msg { struct Header { builtin_interfaces::msg::Time stamp; string frame_id; }; }; };
================================================================================
IDL: builtin_interfaces/msg/Time
module builtin_interfaces { module msg { struct Time { int32 sec; uint32 nanosec; }; }; };
"""


def nanoseconds(seconds: float) -> int:
    return round(seconds * 1e9)


def header(seconds: float, frame_id: str = "base") -> Any:
    stamp = make("builtin_interfaces/msg/Time", *divmod(nanoseconds(seconds), 10**9))
    return make("std_msgs/msg/Header", stamp=stamp, frame_id=frame_id)


def joint_state(
    seconds: float,
    names: Iterable[str],
    position: Iterable[float],
    velocity: Iterable[float] = (),
    effort: Iterable = (),
) -> Any:
    arrays = (np.array(list(numbers), np.float64) for numbers in (position, velocity, effort))
    return make("sensor_msgs/msg/JointState", header(seconds), list(names), *arrays)


def imu(seconds: float, frame_id: str, force: Iterable[float] = (0.0, 9.81, 0.0)) -> Any:
    vector, zeros = make("geometry_msgs/msg/Vector3", *force), np.zeros(9)
    upright = make("geometry_msgs/msg/Quaternion", 0.0, 0.0, 0.0, 1.0)
    return make("sensor_msgs/msg/Imu", header(seconds, frame_id), upright, zeros, vector, zeros, vector, zeros)


def write_mcap_channels(path: Path, channels: Iterable[tuple], **writer: Any) -> Path:
    """MCAP of channels (topic, type, encoding, schema encoding, schema, messages), in the order of log times."""
    with path.open("wb") as stream:
        log = Writer(stream, **writer)
        log.start("", "foreign")
        rows = []
        for topic, kind, encoding, schema_encoding, schema, messages in channels:
            number = log.register_channel(topic, encoding, log.register_schema(kind, schema_encoding, schema))
            rows += [(log_time, number, data) for log_time, data in messages]
        for log_time, number, data in sorted(rows, key=lambda row: row[0]):
            log.add_message(number, log_time, data, log_time)
        log.finish()
    return path


def ros2(topic: str, messages: Iterable[Any], idl: bool = False) -> tuple:
    """Channel of ROS 2 messages, which are recorded at 50 Hz, whatever their stamps."""
    messages = list(messages)
    kind = messages[0].__msgtype__
    text = IDL if idl else typestore().generate_msgdef(kind, ros_version=2)[0]
    data = [bytes(typestore().serialize_cdr(message, kind)) for message in messages]
    rows = [(nanoseconds(START + i / RATE), content) for i, content in enumerate(data)]
    return topic, kind, "cdr", "ros2idl" if idl else "ros2msg", text.encode(), rows


def joint_states(names: Iterable[str] = JOINTS, angles: np.ndarray = ANGLES, time: np.ndarray = TIME) -> list[Any]:
    return [joint_state(t, names, row) for t, row in zip(time, angles)]


def from_msg(path: Path) -> Path:
    return write_mcap_channels(path / "msg.mcap", [ros2("/joint_states", joint_states())])


def from_idl(path: Path) -> Path:
    return write_mcap_channels(path / "idl.mcap", [ros2("/joint_states", joint_states(), idl=True)])


def from_json(path: Path) -> Path:
    rows = []
    for t, row in zip(TIME, ANGLES):
        message = {"names": JOINTS, "position": list(row), "note": "a text"}
        rows.append((nanoseconds(t), json.dumps(message).encode()))
    schema = json.dumps({"type": "object"}).encode()
    return write_mcap_channels(path / "json.mcap", [("/boom/angles", "Angles", "json", "jsonschema", schema, rows)])


def foxglove_tree(seconds: float, row: Iterable[float]) -> dict[str, Any]:
    sec, nsec = divmod(nanoseconds(seconds), 10**9)
    joints = [{"name": name, "position": angle} for name, angle in zip(JOINTS, row)]
    return {"timestamp": {"sec": sec, "nsec": nsec}, "joints": joints}


def from_foxglove_json(path: Path) -> Path:
    rows = [(nanoseconds(t), json.dumps(foxglove_tree(t, row)).encode()) for t, row in zip(TIME, ANGLES)]
    channel = ("/joint_states", "foxglove.JointStates", "json", "jsonschema", b"{}", rows)
    return write_mcap_channels(path / "foxglove_json.mcap", [channel])


@cache
def foxglove_files() -> descriptor_pb2.FileDescriptorSet:
    """Descriptors of foxglove.JointStates, as Foxglove publishes them."""
    file = descriptor_pb2.FileDescriptorProto(name="foxglove/JointStates.proto", package="foxglove", syntax="proto3")
    file.dependency.append("google/protobuf/timestamp.proto")
    kind = descriptor_pb2.FieldDescriptorProto
    joint = file.message_type.add(name="JointState")
    joint.field.add(name="name", number=1, type=kind.TYPE_STRING, label=kind.LABEL_OPTIONAL)
    for i, name in enumerate(("position", "velocity", "acceleration", "effort")):
        joint.oneof_decl.add(name=f"_{name}")
        joint.field.add(
            name=name,
            number=i + 2,
            type=kind.TYPE_DOUBLE,
            label=kind.LABEL_OPTIONAL,
            oneof_index=i,
            proto3_optional=True,
        )
    joints = file.message_type.add(name="JointStates")
    stamp = {"type_name": ".google.protobuf.Timestamp", "type": kind.TYPE_MESSAGE, "label": kind.LABEL_OPTIONAL}
    joints.field.add(name="timestamp", number=1, **stamp)
    of_joints = {"type_name": ".foxglove.JointState", "type": kind.TYPE_MESSAGE, "label": kind.LABEL_REPEATED}
    joints.field.add(name="joints", number=2, **of_joints)
    files = descriptor_pb2.FileDescriptorSet()
    timestamp_pb2.DESCRIPTOR.CopyToProto(files.file.add())
    files.file.add().CopyFrom(file)
    return files


def from_protobuf(path: Path) -> Path:
    pool = descriptor_pool.DescriptorPool()
    for file in foxglove_files().file:
        pool.Add(file)
    kind = message_factory.GetMessageClass(pool.FindMessageTypeByName("foxglove.JointStates"))
    rows = []
    for t, row in zip(TIME, ANGLES):
        sec, nanos = divmod(nanoseconds(t), 10**9)
        joints = [{"name": name, "position": angle} for name, angle in zip(JOINTS, row)]
        message = kind(timestamp={"seconds": sec, "nanos": nanos}, joints=joints)
        rows.append((nanoseconds(t), message.SerializeToString()))
    schema = foxglove_files().SerializeToString()
    channel = ("/joint_states", "foxglove.JointStates", "protobuf", "protobuf", schema, rows)
    return write_mcap_channels(path / "foxglove.mcap", [channel])


def from_ros1(path: Path) -> Path:
    store = get_typestore(Stores.ROS1_NOETIC)
    types, log = store.types, path / "ros1.bag"
    with Ros1Writer(log) as bag:
        connection = bag.add_connection("/joint_states", "sensor_msgs/msg/JointState", typestore=store)
        for i, (t, row) in enumerate(zip(TIME, ANGLES)):
            stamp = types["builtin_interfaces/msg/Time"](*divmod(nanoseconds(t), 10**9))
            head = types["std_msgs/msg/Header"](seq=i, stamp=stamp, frame_id="")
            empty = np.empty(0)
            message = types["sensor_msgs/msg/JointState"](head, list(JOINTS), row, empty, empty)
            bag.write(connection, nanoseconds(t), store.serialize_ros1(message, "sensor_msgs/msg/JointState"))
    return log


def from_ros2_bag(path: Path) -> Path:
    log = path / "ros2"
    with Ros2Writer(log, version=9, storage_plugin=StoragePlugin.SQLITE3) as bag:
        connection = bag.add_connection("/joint_states", "sensor_msgs/msg/JointState", typestore=typestore())
        for t, message in zip(TIME, joint_states()):
            bag.write(connection, nanoseconds(t), typestore().serialize_cdr(message, "sensor_msgs/msg/JointState"))
    return log


def from_database(path: Path) -> Path:
    return from_ros2_bag(path) / "ros2.db3"


def csv_text(between: str = ",", comma: bool = False) -> str:
    names = ["time_s", *(f"q{i}_rad" for i in range(1, 6)), "note"]
    rows = [[repr(float(t)), *(repr(float(x)) for x in row), "ok"] for t, row in zip(TIME, ANGLES)]
    lines = [between.join(cell.replace(".", ",") if comma else cell for cell in row) for row in rows]
    return "\n".join([between.join(names), *lines]) + "\n"


def from_csv(path: Path) -> Path:
    (path / "log.csv").write_text(csv_text())
    return path / "log.csv"


def from_german_csv(path: Path) -> Path:
    (path / "german.csv").write_text(csv_text(";", comma=True), encoding="utf-8-sig")
    return path / "german.csv"


def from_gzipped_csv(path: Path) -> Path:
    (path / "log.csv.gz").write_bytes(gzip.compress(csv_text().encode(), mtime=0))
    return path / "log.csv.gz"


WRITERS = (
    from_msg, from_idl, from_json, from_foxglove_json, from_protobuf, from_ros1, from_ros2_bag, from_database,
    from_csv, from_german_csv, from_gzipped_csv,
)  # fmt: skip


def angles_entry(**changes) -> Entry:
    usual = {"signal": "joint/position", "topic": "/joint_states", "field": "position", "unit": "rad"}
    return Entry(**(usual | changes))


def read(path: Path, *entries: Entry) -> Recording:
    return read_log(path, TopicMap(entries))


def proposed(path: Path, tmp_path: Path) -> TopicMap:
    """The proposed map, its guesses taken as right."""
    file = tmp_path / "map.toml"
    file.write_text(propose_map(inspect_log(path)).replace('?"', '"'))
    return load_topic_map(file)


def log_of(path: Path, messages: list) -> Path:
    return write_mcap_channels(path / "log.mcap", [ros2("/joint_states", messages)])
