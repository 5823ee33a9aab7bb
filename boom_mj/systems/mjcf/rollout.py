"""An MJCF machine along a stretch of a log: some joints follow their measured motion, actuators their commands.

A driven joint carries a huge armature A and a servo whose reference is fed forward, so that nothing pushes it off its
path; what the servo exerts beyond accelerating A is the force of its actuator. It is how the boom is driven, too.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import mujoco
import numpy as np
from mujoco.batch import Batch

from boom_mj.engine import mass_matrix
from boom_mj.simulation.diverged import diverged

Array = np.ndarray
HEAVY = 1e6  # armature of a driven joint over its own inertia
SERVO = 2 * np.pi * 2.0  # rad/s
DRIVE, HAND = "drive/", "hand/"  # actuators of ours: servos, and forces by hand


@dataclass(frozen=True)
class Inputs:
    """What goes into a simulation, at its steps.

    Attributes:
        time: (n,), s from 0.
        path: of driven joints, by name, (n,).
        command: of actuators, by name, (n,).
        force: on joints, by name, (n,).
        start: position and speed of joints that are free, by name.
    """

    time: Array
    path: Mapping[str, Array]
    command: Mapping[str, Array]
    force: Mapping[str, Array]
    start: Mapping[str, tuple[float, float]]


@dataclass(frozen=True)
class Run:
    """A simulated stretch: every entry (n,), by name.

    Attributes:
        position, velocity: of joints.
        force: of actuators, at their joints; of driven joints under the joint's name.
        sensordata: (n, nsensordata).
    """

    time: Array
    position: Mapping[str, Array]
    velocity: Mapping[str, Array]
    acceleration: Mapping[str, Array]
    force: Mapping[str, Array]
    sensordata: Array


def drivable(spec: mujoco.MjSpec, driven: tuple[str, ...], pushed: tuple[str, ...]) -> mujoco.MjModel:
    """A compiled copy in which joints can be driven and pushed by hand; their own actuators are taken away."""
    spec = spec.copy()
    for actuator in list(spec.actuators):
        if actuator.target in driven and not actuator.name.startswith("push/"):
            spec.delete(actuator)
    if spec.option.integrator == mujoco.mjtIntegrator.mjINT_RK4:  # it looks at times between steps
        spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    for joint in pushed:
        hand = spec.add_actuator(name=HAND + joint, target=joint, trntype=mujoco.mjtTrn.mjTRN_JOINT)
        hand.set_to_motor()
    for joint in driven:
        spec.joint(joint).limited = mujoco.mjtLimited.mjLIMITED_FALSE
        servo = spec.add_actuator(name=DRIVE + joint, target=joint, trntype=mujoco.mjtTrn.mjTRN_JOINT)
        servo.gaintype, servo.biastype = mujoco.mjtGain.mjGAIN_FIXED, mujoco.mjtBias.mjBIAS_AFFINE
    model = spec.compile()
    mass = mass_matrix(model)
    for joint in driven:
        dof, servo = model.joint(joint).dofadr[0], model.actuator(DRIVE + joint)
        heavy = HEAVY * float(mass[dof, dof])
        model.dof_armature[dof] += heavy
        servo.gainprm[0], servo.biasprm[:3] = heavy * SERVO**2, (0, -heavy * SERVO**2, 0)
        servo.gear[0] = 1.0
    mujoco.mj_setConst(model, mujoco.MjData(model))
    return model


def joint_of(spec: mujoco.MjSpec, actuator: str) -> str:
    """Joint that an actuator moves, "" if it moves none."""
    found = spec.actuator(actuator)
    return found.target if found is not None and found.trntype == mujoco.mjtTrn.mjTRN_JOINT else ""


def heavy_armature(model: mujoco.MjModel, joint: str) -> float:
    """What a servo carries besides the machine."""
    return float(model.actuator(DRIVE + joint).gainprm[0]) / SERVO**2


def simulate(model: mujoco.MjModel, inputs: Inputs) -> Run:
    """Simulate a inputs.

    Raises:
        SimulationError: the simulation diverged.
    """
    time = inputs.time
    step, count = model.opt.timestep, len(time)
    control = np.zeros((count, model.nu))
    batch = Batch(model, 1, 1)
    batch.qpos[0], batch.qvel[0] = model.qpos0, 0
    for joint, (position, speed) in inputs.start.items():
        address, dof = model.joint(joint).qposadr[0], model.joint(joint).dofadr[0]
        batch.qpos[0, address], batch.qvel[0, dof] = position, speed
    for joint, path in inputs.path.items():
        before, after = (3 * a - 3 * b + c for a, b, c in (path[:3], path[:-4:-1]))
        padded = np.concatenate([[before], path, [after]])
        speed = np.diff(padded) / step
        control[:, model.actuator(DRIVE + joint).id] = path + np.diff(speed) / step / SERVO**2
        batch.qpos[0, model.joint(joint).qposadr[0]] = path[0]
        batch.qvel[0, model.joint(joint).dofadr[0]] = speed[0]
    for name, command in inputs.command.items():
        actuator = model.actuator(name)
        control[:, actuator.id] = command
        if actuator.actnum[0] == 1:
            batch.act[0, actuator.actadr[0]] = command[0]
    for joint, force in inputs.force.items():
        control[:, model.actuator(HAND + joint).id] = force

    qpos, qvel = np.empty((1, count + 1, model.nq)), np.empty((1, count + 1, model.nv))
    qpos[0, 0], qvel[0, 0] = batch.qpos[0], batch.qvel[0]
    record = batch.rollout(count, control[None], record=("qpos", "qvel", "qacc", "sensordata", "actuator_force"))
    qpos[:, 1:], qvel[:, 1:] = record["qpos"], record["qvel"]
    if batch.warning[0].any() or not np.isfinite(qpos[0, -1]).all():
        raise diverged(model, qpos[0], qvel[0], batch.warning[0], "the model")
    middle = (qvel[0, :-1] + qvel[0, 1:]) / 2
    joints = [model.joint(k) for k in range(model.njnt) if model.joint(k).type[0] in (2, 3)]
    exerted = record["actuator_force"][0] * model.actuator_gear[:, 0]
    forces = {model.actuator(k).name: exerted[:, k] for k in range(model.nu)}
    acceleration = {j.name: record["qacc"][0][:, j.dofadr[0]] for j in joints}
    driven = {j: forces[DRIVE + j] - heavy_armature(model, j) * acceleration[j] for j in inputs.path}
    return Run(
        time,
        {j.name: qpos[0, :-1, j.qposadr[0]] for j in joints},
        {j.name: middle[:, j.dofadr[0]] for j in joints},
        acceleration,
        {**forces, **driven},
        record["sensordata"][0],
    )
