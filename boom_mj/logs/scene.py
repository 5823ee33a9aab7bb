"""A moving scene as ROS 2 messages: /tf for the frames, /scene for the shapes that hang on them."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from boom_mj.logs.messages import make
from boom_mj.recording import Scene

TYPES = {"/tf": "tf2_msgs/msg/TFMessage", "/scene": "visualization_msgs/msg/MarkerArray"}
TRIANGLE_LIST = 11  # visualization_msgs/msg/Marker


def scene_messages(scene: Scene) -> Iterator[tuple[int, str, Any]]:
    """Stamp in ns, topic and message: the shapes once, at the start, and the frames at all times."""
    stamps = np.round(scene.time * 1e9).astype(np.int64)
    positions, quaternions = scene.position.tolist(), np.roll(scene.quaternion, -1, axis=-1).tolist()
    yield int(stamps[0]), "/scene", _shapes(scene, int(stamps[0]))
    for i, stamp in enumerate(stamps):
        head = _header(int(stamp), "world")
        moved = [
            make(
                "geometry_msgs/msg/TransformStamped",
                header=head,
                child_frame_id=frame,
                transform=make(
                    "geometry_msgs/msg/Transform",
                    translation=make("geometry_msgs/msg/Vector3", *positions[i][k]),
                    rotation=make("geometry_msgs/msg/Quaternion", *quaternions[i][k]),
                ),
            )
            for k, frame in enumerate(scene.frames)
        ]
        yield int(stamp), "/tf", make(TYPES["/tf"], transforms=moved)


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
    time = make("builtin_interfaces/msg/Time", *divmod(stamp, 10**9))
    return make("std_msgs/msg/Header", stamp=time, frame_id=frame)
