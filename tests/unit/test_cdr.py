"""CDR decoded all at once equals what rosbags decodes one by one."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from boom_mj.logs.channel import Channel
from boom_mj.logs.encodings import decoder_of
from boom_mj.logs.messages import typestore

KINDS = ("sensor_msgs/msg/JointState", "sensor_msgs/msg/Imu", "geometry_msgs/msg/PoseArray",
         "geometry_msgs/msg/WrenchStamped", "trajectory_msgs/msg/JointTrajectory", "tf2_msgs/msg/TFMessage",
         "sensor_msgs/msg/BatteryState", "diagnostic_msgs/msg/DiagnosticArray")  # fmt: skip
SIZES = {"bool": 1, "byte": 127, "char": 255, "int8": 127, "uint8": 255, "int16": 999, "uint16": 999, "int32": 999,
         "uint32": 999, "int64": 999, "uint64": 999}  # fmt: skip


def random_value(description, rng):
    kind, detail = int(description[0]), description[1]
    if kind == 2:
        return random_message(detail, rng)
    if kind == 1:
        if detail[0] == "string":
            return "äöü boom"[: rng.integers(0, 9)]
        return float(np.float32(rng.normal())) if "float" in detail[0] else int(rng.integers(0, SIZES[detail[0]] + 1))
    element, count = detail[0], detail[1] if kind == 3 else int(rng.integers(0, 4))
    if int(element[0]) == 1 and element[1][0] != "string":
        return np.array([random_value(element, rng) for _ in range(count)], element[1][0].replace("byte", "uint8"))
    return [random_value(element, rng) for _ in range(count)]


def random_message(kind, rng):
    fields = typestore().fielddefs[kind][1]
    return typestore().types[kind](**{name: random_value(description, rng) for name, description in fields})


def numbers_of(message, path):
    """Numbers at a path, element by element: the slow way."""
    nodes = [message]
    for step in path.split("."):
        nodes = [getattr(node, step.removesuffix("[]")) for node in nodes]
        if step.endswith("[]"):
            nodes = [element for node in nodes for element in node]
    return [float(x) for node in nodes for x in _flat(node)]


def _flat(node):
    if hasattr(node, "x"):
        return [getattr(node, axis) for axis in "xyzw" if hasattr(node, axis)]
    return np.ravel(node)


PATHS = {
    KINDS[0]: ("position", "velocity", "effort"), KINDS[1]: ("orientation", "angular_velocity_covariance"),
    KINDS[2]: ("poses[].position", "poses[].orientation"), KINDS[3]: ("wrench.torque",),
    KINDS[4]: ("points[].time_from_start.sec",), KINDS[5]: ("transforms[].transform.translation",),
    KINDS[6]: ("voltage", "cell_voltage", "present"), KINDS[7]: ("status[].level",),
}  # fmt: skip


@settings(max_examples=60, deadline=None)
@given(
    kind=st.sampled_from(KINDS),
    seed=st.integers(0, 2**32 - 1),
    encoding=st.sampled_from(["cdr", "big-endian cdr", "ros1"]),
    count=st.integers(1, 12),
)
def test_messages_decoded_at_once_equal_those_that_rosbags_decodes(kind, seed, encoding, count):
    rng = np.random.default_rng(seed)
    messages = [random_message(kind, rng) for _ in range(count)]
    for message in messages:
        if kind == KINDS[0]:  # names and numbers go together, or there are no numbers
            message.name = [f"j{i}" for i in range(rng.integers(0, 3))]
            for field in ("position", "velocity", "effort"):
                setattr(message, field, rng.normal(size=len(message.name) * rng.integers(0, 2)))
    if encoding == "ros1":
        data = [bytes(typestore().serialize_ros1(message, kind)) for message in messages]
    else:
        little = encoding == "cdr"
        data = [bytes(typestore().serialize_cdr(message, kind, little_endian=little)) for message in messages]
    decoder = decoder_of(Channel(1, "/t", kind, encoding.rpartition(" ")[2]))
    seen = []
    for group in decoder.decode(data, PATHS[kind]):
        seen += list(group.which)
        for row, i in enumerate(group.which):
            decode = typestore().deserialize_ros1 if encoding == "ros1" else typestore().deserialize_cdr
            theirs = decode(data[i], kind)
            for path in PATHS[kind]:
                assert list(group.columns[path].values[row]) == numbers_of(theirs, path)
            if hasattr(theirs, "header"):
                assert group.stamp[row] == theirs.header.stamp.sec * 10**9 + theirs.header.stamp.nanosec
                assert group.frame_id == theirs.header.frame_id
    assert sorted(seen) == list(range(count))
