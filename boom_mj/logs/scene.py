"""A moving scene as ROS 2 messages: /tf for the frames, /scene for the shapes that hang on them."""

from functools import partial
from typing import Any

import numpy as np

from boom_mj.logs.messages import make
from boom_mj.logs.serialising import Pack, stamp_of
from boom_mj.recording import Scene

Array = np.ndarray
TYPES = {"/tf": "tf2_msgs/msg/TFMessage", "/scene": "visualization_msgs/msg/MarkerArray"}
TRIANGLE_LIST = 11  # visualization_msgs/msg/Marker


def shapes(scene: Scene) -> tuple[int, str, Any]:
    """Stamp in ns, topic and message of the shapes, which are said once, at the start."""
    stamp = int(_stamps(scene)[0])
    return stamp, "/scene", _shapes(scene, stamp)


def frames(scene: Scene) -> tuple[Pack, Array, Array]:
    """Of the frames at all times: how a message is packed, stamps in ns, (n,), and numbers, (n, 7 m)."""
    placed = np.concatenate(
        [scene.position, np.roll(scene.quaternion, -1, axis=-1)], axis=-1
    )  # (n, m, 7), x y z w last
    return partial(_moved, scene.frames), _stamps(scene), placed.reshape(len(placed), -1)


def _moved(names: tuple[str, ...], stamp: Any, numbers: Array) -> Any:
    head = make("std_msgs/msg/Header", stamp=stamp, frame_id="world")
    transforms = [
        make(
            "geometry_msgs/msg/TransformStamped",
            header=head,
            child_frame_id=name,
            transform=make(
                "geometry_msgs/msg/Transform",
                translation=make("geometry_msgs/msg/Vector3", *place[:3]),
                rotation=make("geometry_msgs/msg/Quaternion", *place[3:]),
            ),
        )
        for name, place in zip(names, numbers.reshape(-1, 7))
    ]
    return make(TYPES["/tf"], transforms=transforms)


def _stamps(scene: Scene) -> Array:
    return np.round(scene.time * 1e9).astype(np.int64)


def _shapes(scene: Scene, stamp: int) -> Any:
    """Markers that stay (lifetime 0) and follow their frames (frame_locked)."""
    zero = make("builtin_interfaces/msg/Duration", sec=0, nanosec=0)
    upright = make("geometry_msgs/msg/Quaternion", 0.0, 0.0, 0.0, 1.0)
    pose = make("geometry_msgs/msg/Pose", position=make("geometry_msgs/msg/Point", 0.0, 0.0, 0.0), orientation=upright)
    image = make("sensor_msgs/msg/CompressedImage", header=_header(stamp, ""), format="", data=np.zeros(0, np.uint8))
    mesh = make("visualization_msgs/msg/MeshFile", filename="", data=np.zeros(0, np.uint8))
    markers = [
        make(
            "visualization_msgs/msg/Marker",
            header=_header(stamp, frame),
            ns="boom",
            id=k,
            type=TRIANGLE_LIST,
            action=0,
            pose=pose,
            scale=make("geometry_msgs/msg/Vector3", 1.0, 1.0, 1.0),
            color=make("std_msgs/msg/ColorRGBA", *scene.color, 1.0),
            lifetime=zero,
            frame_locked=True,
            points=[make("geometry_msgs/msg/Point", *map(float, corner)) for corner in scene.triangles[k]],
            colors=[],
            texture_resource="",
            texture=image,
            uv_coordinates=[],
            text="",
            mesh_resource="",
            mesh_file=mesh,
            mesh_use_embedded_materials=False,
        )
        for k, frame in enumerate(scene.frames)
        if len(scene.triangles[k])
    ]
    return make(TYPES["/scene"], markers=markers)


def _header(stamp: int, frame: str) -> Any:
    return make("std_msgs/msg/Header", stamp=stamp_of(stamp), frame_id=frame)
