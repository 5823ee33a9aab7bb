"""The boom of a simulated motion as a moving scene."""

from collections.abc import Mapping, Sequence

import mujoco
import numpy as np

from boom_mj.mjcf import YELLOW, box_corners
from boom_mj.recording import Scene
from boom_mj.recording.names import JOINTS
from boom_mj.simulation import Trajectory

Pose = tuple[np.ndarray, np.ndarray]
RATE = 20.0  # Hz
PIECES = 6  # of a link, as it is drawn
FACES = (0, 3, 2, 0, 1, 3, 4, 7, 5, 4, 6, 7, 0, 5, 1, 0, 4, 5, 2, 7, 6, 2, 3, 7, 0, 6, 4, 0, 2, 6, 1, 7, 3, 1, 5, 7)
"""Corners of the twelve triangles of a box, outward, as `box_corners` counts them."""


def boom_scene(trajectory: Trajectory, start: float = 0.0, fixed: Mapping[str, Pose] | None = None) -> Scene:
    """The boom as frames and boxes, sampled at RATE; the frames are the same for any number of hinges.

    base and turret; link2, .. at the roots; link2_1 .. link2_6, on which the pieces of the box hang, from the root
    outward; link2_tip, .. as the IMUs have it. All of a link's frames are its link-tip frame on that body.

    Args:
        start: the recording's first stamp, s.
        fixed: further frames that do not move, such as cameras: place (3,) m and quaternion w x y z (4,).
    """
    model, machine, fixed = trajectory.plant.model, trajectory.plant.machine, fixed or {}
    bodies = {name: model.body(name).id for name in ("base", "turret")}
    shapes: dict[str, np.ndarray] = {}
    for index, link in enumerate(machine.links):
        bodies[link.name] = model.body(link.name).id
        segments = _segments(model, link.name)
        cuts = np.linspace(-link.length, 0.0, PIECES + 1)
        for piece in range(PIECES):
            frame, middle = f"{link.name}_{piece + 1}", cuts[piece : piece + 2].mean()
            bodies[frame] = next((body for body, end in segments if middle <= end), segments[-1][0])
            shapes[frame] = box_corners(machine, index, *cuts[piece : piece + 2])[list(FACES)]
        bodies[f"{link.name}_tip"] = model.site(f"imu_{link.name}").bodyid[0]
    data, which = mujoco.MjData(model), np.array([*bodies.values()])
    steps = np.arange(0, len(trajectory.time), max(1, round(1 / RATE / model.opt.timestep)))
    position = np.empty((len(steps), len(which) + len(fixed), 3))
    quaternion = np.empty((*position.shape[:2], 4))
    for k, pose in enumerate(fixed.values()):
        position[:, len(which) + k], quaternion[:, len(which) + k] = pose
    for row, step in enumerate(steps):
        data.qpos[:] = trajectory.qpos[step]
        mujoco.mj_kinematics(model, data)
        position[row, : len(which)], quaternion[row, : len(which)] = data.xpos[which], data.xquat[which]
    frames = (*bodies, *fixed)
    return Scene(
        time=trajectory.time[steps] + start,
        frames=frames,
        position=position,
        quaternion=quaternion,
        triangles=tuple(shapes.get(frame, np.zeros((0, 3))) for frame in frames),
        color=YELLOW[:3],
    )


def boom_lines(trajectory: Trajectory, steps: Sequence[int], bent: bool = True) -> np.ndarray:
    """The boom as a line at some steps, from the ground over joints and markers to the tip, (len(steps), p, 3), m.

    Args:
        bent: with the elastic hinges as they are, or at zero.
    """
    model = trajectory.plant.model
    data, joints = mujoco.MjData(model), [model.joint(name).id for name in JOINTS]
    markers = [k for k in range(model.nsite) if model.site(k).name.startswith("marker")]
    elastic = np.setdiff1d(np.arange(model.nq), model.jnt_qposadr[joints])
    lines = []
    for step in steps:
        data.qpos[:] = trajectory.qpos[step]
        if not bent:
            data.qpos[elastic] = 0
        mujoco.mj_kinematics(model, data)
        root, *anchors = data.xanchor[joints]
        per_link = data.site_xpos[markers].reshape(len(anchors), -1, 3)
        parts = [root[None], *(np.vstack([anchor, sites]) for anchor, sites in zip(anchors, per_link))]
        lines.append(np.vstack([root * [1, 1, 0], *parts, data.site("tip").xpos]))
    return np.array(lines)


def _segments(model: mujoco.MjModel, link: str) -> list[tuple[int, float]]:
    """Bodies of a link, root outward, each with the x where its box ends."""
    found = []
    for number in range(1, model.nbody):
        body = model.body(link if number == 1 else f"{link}_{number}").id
        geom = next(g for g in range(model.ngeom) if model.geom_bodyid[g] == body and model.geom_dataid[g] >= 0)
        found.append((body, float(_ends(model, geom)[1])))
        if found[-1][1] >= -1e-6:
            return found
    raise AssertionError(f"{link} has no end")


def _ends(model: mujoco.MjModel, geom: int) -> np.ndarray:
    """Least and largest x of a mesh in the frame of its body, (2,), m."""
    mesh = model.geom_dataid[geom]
    vertices = model.mesh_vert[model.mesh_vertadr[mesh] :][: model.mesh_vertnum[mesh]]
    rotation = np.zeros(9)
    mujoco.mju_quat2Mat(rotation, model.geom_quat[geom])
    x = vertices @ rotation.reshape(3, 3)[0] + model.geom_pos[geom, 0]
    return np.array([x.min(), x.max()])
