"""The boom of a simulated motion as a moving scene."""

from collections.abc import Sequence

import mujoco
import numpy as np

from boom_mj.mjcf import YELLOW
from boom_mj.recording import Scene
from boom_mj.recording.names import JOINTS
from boom_mj.simulation import Trajectory

RATE = 20.0  # Hz


def boom_scene(trajectory: Trajectory, start: float = 0.0) -> Scene:
    """Frames and boxes of all bodies of the boom, sampled at RATE; `start` (s) is the recording's first stamp."""
    model = trajectory.plant.model
    data, bodies = mujoco.MjData(model), range(1, model.nbody)
    steps = np.arange(0, len(trajectory.time), max(1, round(1 / RATE / model.opt.timestep)))
    position, quaternion = np.empty((len(steps), model.nbody, 3)), np.empty((len(steps), model.nbody, 4))
    for row, step in enumerate(steps):
        data.qpos[:] = trajectory.qpos[step]
        mujoco.mj_kinematics(model, data)
        position[row], quaternion[row] = data.xpos, data.xquat
    return Scene(
        time=trajectory.time[steps] + start,
        frames=tuple(model.body(k).name for k in bodies),
        position=position[:, 1:],
        quaternion=quaternion[:, 1:],
        triangles=tuple(_surface(model, k) for k in bodies),
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


def _surface(model: mujoco.MjModel, body: int) -> np.ndarray:
    """Corners of the triangles of a body's meshes in its frame, (3 k, 3), m."""
    corners = [np.zeros((0, 3))]
    for geom in range(model.body_geomadr[body], model.body_geomadr[body] + model.body_geomnum[body]):
        mesh = model.geom_dataid[geom]
        if model.geom_type[geom] != mujoco.mjtGeom.mjGEOM_MESH:
            continue
        vertices = model.mesh_vert[model.mesh_vertadr[mesh] :][: model.mesh_vertnum[mesh]]
        faces = model.mesh_face[model.mesh_faceadr[mesh] :][: model.mesh_facenum[mesh]]
        rotation = np.zeros(9)
        mujoco.mju_quat2Mat(rotation, model.geom_quat[geom])
        corners.append(vertices[faces.ravel()] @ rotation.reshape(3, 3).T + model.geom_pos[geom])
    return np.concatenate(corners)
