"""Keyframes of a model: poses in static equilibrium under weight, in which its drives hold it as it opens anywhere."""

from collections.abc import Mapping

import mujoco
import numpy as np

Array = np.ndarray

POSES_DEG: Mapping[str, tuple[float, float, float, float, float]] = {
    "stretched": (0.0, 0.0, 0.0, 0.0, 0.0),
    "bow": (0.0, 60.0, -35.0, -40.0, -45.0),
    "folded": (0.0, 35.0, -165.0, -170.0, -170.0),
}
"""Joint angles that everyone knows by name."""
TURNS = 500  # of the iteration, which gains a digit in one to three
SETTLED = 1e-10  # rad


def add_keyframes(spec: mujoco.MjSpec, poses: Mapping[str, Array]) -> None:
    """Add a keyframe for every pose (q1.., rad) within the joints' limits: qpos at rest, ctrl that keeps it there.

    A pose at a joint's limit needs a command beyond it: the drive's range is widened to hold that.
    """
    model = spec.compile()
    data = mujoco.MjData(model)
    count = len(next(iter(poses.values())))
    joints = [model.joint(f"joint{k + 1}") for k in range(count)]
    places = np.array([joint.qposadr[0] for joint in joints], int)
    for name, angles in poses.items():
        if any(not low - 1e-9 <= q <= high + 1e-9 for q, (low, high) in zip(angles, (j.range for j in joints))):
            continue
        data.qpos[:] = 0
        data.qpos[places] = angles
        missing = _settle(model, data, places)
        if missing is None:
            continue
        ctrl = np.zeros(model.nu)
        for k, q in enumerate(angles):  # a position servo is off by torque / gain
            drive = model.actuator(f"drive{k + 1}")
            ctrl[drive.id] = q + missing[places[k]] / drive.gainprm[0]
            low, high = spec.actuator(drive.name).ctrlrange
            spec.actuator(drive.name).ctrlrange = [min(low, ctrl[drive.id]), max(high, ctrl[drive.id])]
        spec.add_key(name=name, qpos=data.qpos.copy(), ctrl=ctrl)


def _settle(model: mujoco.MjModel, data: mujoco.MjData, held: Array) -> Array | None:
    """Bend what gives until springs bear the weight; forces that are missing then, (nv,), or None where none do."""
    gives = np.setdiff1d(np.arange(model.nv), held)
    stiffness = model.jnt_stiffness.reshape(model.njnt, -1)[model.dof_jntid[gives], 0]
    if not (stiffness > 0).all():
        return None
    for _ in range(TURNS):
        mujoco.mj_fwdPosition(model, data)
        mujoco.mj_fwdVelocity(model, data)
        missing: Array = data.qfrc_bias - data.qfrc_passive
        step = -missing[gives] / stiffness
        data.qpos[gives] += step
        if np.abs(step).max(initial=0.0) < SETTLED:
            return missing
    return None
