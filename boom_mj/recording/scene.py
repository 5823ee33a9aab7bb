"""A moving scene: rigid shapes on moving frames, for viewers that show a recording in 3D."""

from dataclasses import dataclass

import numpy as np

Array = np.ndarray


@dataclass(frozen=True, eq=False)
class Scene:
    """Frames that move in the world, each with a shape.

    Attributes:
        time: (n,), s.
        frames: names of the m frames.
        position: of the frames in the world, (n, m, 3), m.
        quaternion: of the frames in the world, (n, m, 4), w x y z.
        triangles: per frame the corners of its surface in the frame, (3 k, 3), m.
        color: of all shapes, red green blue, 0 to 1.
    """

    time: Array
    frames: tuple[str, ...]
    position: Array
    quaternion: Array
    triangles: tuple[Array, ...]
    color: tuple[float, float, float]
