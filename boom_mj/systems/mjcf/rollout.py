"""An MJCF machine along a stretch of a log: some joints follow their measured motion, actuators their commands.

A driven joint carries a huge armature A and a servo whose reference is fed forward, so that nothing pushes it off its
path; what the servo exerts beyond accelerating A is the force of its actuator. It is how the boom is driven, too.
"""

from collections.abc import Mapping, Sequence
from contextlib import nullcontext
from dataclasses import dataclass, field

import mujoco
import numpy as np
from mujoco.batch import Batch

from boom_mj.effects.filters import Running
from boom_mj.engine import mass_matrix
from boom_mj.errors import SimulationError
from boom_mj.simulation.diverged import diverged
from boom_mj.systems.mjcf.pushing import Push, together

Array = np.ndarray
HEAVY = 1e6  # armature of a driven joint over its own inertia
SERVO = 2 * np.pi * 2.0  # rad/s
THREADS = 1  # of one simulation; several run at a time
RECORD = "qpos", "qvel", "qacc", "sensordata", "actuator_force"
IMPLICIT = mujoco.mjtIntegrator.mjINT_IMPLICIT, mujoco.mjtIntegrator.mjINT_IMPLICITFAST
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
        reaction: on joints, by name, beside `force`: what follows from the motion, of as many commands.
    """

    time: Array
    path: Mapping[str, Array]
    command: Mapping[str, Array]
    force: Mapping[str, Array]
    start: Mapping[str, tuple[float, float]]
    reaction: Mapping[str, Push] = field(default_factory=dict)


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


def simulate(model: mujoco.MjModel, stretches: Sequence[Inputs]) -> list[Run | SimulationError]:
    """Simulate stretches, side by side; where one diverged its error."""
    count = max(len(inputs.time) for inputs in stretches)
    batch, control = Batch(model, len(stretches), THREADS), np.zeros((len(stretches), count, model.nu))
    batch.qpos[:], batch.qvel[:] = model.qpos0, 0
    for row, inputs in enumerate(stretches):
        _begin(model, batch, row, inputs, control[row])
    qpos, qvel = (np.empty((len(stretches), count + 1, size)) for size in (model.nq, model.nv))
    qpos[:, 0], qvel[:, 0] = batch.qpos, batch.qvel
    if any(inputs.reaction for inputs in stretches):
        record = _step_by_step(model, batch, control, stretches)
    else:
        record = batch.rollout(count, control, record=RECORD)
    qpos[:, 1:], qvel[:, 1:] = record["qpos"], record["qvel"]
    runs = list[Run | SimulationError]()
    for row, inputs in enumerate(stretches):
        end = len(inputs.time) + 1
        if batch.warning[row].any() or not np.isfinite(qpos[row, end - 1]).all():
            error = diverged(model, qpos[row, :end], qvel[row, :end], batch.warning[row], "the model")
            runs.append(error)
        else:
            own = {name: values[row, : end - 1] for name, values in record.items()}
            runs.append(_run(model, inputs, qpos[row, : end - 1], qvel[row, :end], own))
    return runs


def _begin(model: mujoco.MjModel, batch: Batch, row: int, inputs: Inputs, control: Array) -> None:
    """The state of one simulation at the beginning of a stretch, and its control, (n, nu); what is over stays."""
    step, count = model.opt.timestep, len(inputs.time)
    for joint, (position, speed) in inputs.start.items():
        address, dof = model.joint(joint).qposadr[0], model.joint(joint).dofadr[0]
        batch.qpos[row, address], batch.qvel[row, dof] = position, speed
    for joint, path in inputs.path.items():
        before, after = (3 * a - 3 * b + c for a, b, c in (path[:3], path[:-4:-1]))
        padded = np.concatenate([[before], path, [after]])
        speed = np.diff(padded) / step
        control[:count, model.actuator(DRIVE + joint).id] = path + np.diff(speed) / step / SERVO**2
        batch.qpos[row, model.joint(joint).qposadr[0]] = path[0]
        batch.qvel[row, model.joint(joint).dofadr[0]] = speed[0]
    for name, command in inputs.command.items():
        actuator = model.actuator(name)
        control[:count, actuator.id] = command
        if actuator.actnum[0] == 1:
            batch.act[row, actuator.actadr[0]] = command[0]
    for joint, force in inputs.force.items():
        control[:count, model.actuator(HAND + joint).id] = force
    control[count:] = control[count - 1]


def _step_by_step(model: mujoco.MjModel, batch: Batch, control: Array, stretches: Sequence[Inputs]) -> dict[str, Array]:
    """What a rollout records where forces follow from what the machine does."""
    count, step = control.shape[1], model.opt.timestep
    time = step * np.arange(-1, count)
    pushed = []
    for joint in stretches[0].reaction:
        push = together([inputs.reaction[joint] for inputs in stretches], count)
        address, dof = model.joint(joint).qposadr[0], model.joint(joint).dofadr[0]
        position, speed, load = np.empty((3, len(stretches), count + 1))
        speed[:, 0] = batch.qvel[:, dof]
        position[:, 0] = batch.qpos[:, address] - step * speed[:, 0]
        load[:, :1] = push.load(position[:, :1], speed[:, :1])
        pushed.append((model.actuator(HAND + joint).id, address, dof, position, speed, load, push, Running()))
    parts = []
    for k in range(count):
        now = slice(k + 1, k + 2)
        for hand, address, dof, position, speed, load, push, filters in pushed:
            position[:, k + 1], speed[:, k + 1] = batch.qpos[:, address], batch.qvel[:, dof]
            load[:, now] = push.load(position[:, now], speed[:, now], k + 1)
            past = slice(0 if push.remembers else k, k + 2)
            with nullcontext() if push.remembers else filters:
                force = push(time[past], position[:, past], speed[:, past], load[:, past], past.start)
            control[:, k, hand] += force[:, -1]
        parts.append(batch.rollout(1, control[:, k : k + 1], record=RECORD))
    return {name: np.concatenate([part[name] for part in parts], axis=1) for name in RECORD}


def _lost(model: mujoco.MjModel, qvel: Array) -> Array:
    """What damping takes off actuators' forces within every step, (n, nu), of speeds (n + 1, nv).

    An implicit step takes the damping of an actuator at the speed that it ends with; MuJoCo tells the force before.
    """
    lost = np.zeros((len(qvel) - 1, model.nu))
    if model.opt.integrator in IMPLICIT:
        change = np.diff(qvel, axis=0)
        for k in np.flatnonzero(model.actuator_trntype == mujoco.mjtTrn.mjTRN_JOINT):
            dof = model.jnt_dofadr[model.actuator_trnid[k, 0]]
            lost[:, k] = -model.actuator_biasprm[k, 2] * model.actuator_gear[k, 0] * change[:, dof]
    return lost


def _run(model: mujoco.MjModel, inputs: Inputs, qpos: Array, qvel: Array, record: Mapping[str, Array]) -> Run:
    """What a stretch did, by name: positions (n, nq) and speeds (n + 1, nv)."""
    middle = (qvel[:-1] + qvel[1:]) / 2
    joints = [model.joint(k) for k in range(model.njnt) if model.joint(k).type[0] in (2, 3)]
    exerted = (record["actuator_force"] - _lost(model, qvel)) * model.actuator_gear[:, 0]
    forces = {model.actuator(k).name: exerted[:, k] for k in range(model.nu)}
    acceleration = {j.name: record["qacc"][:, j.dofadr[0]] for j in joints}
    driven = {j: forces[DRIVE + j] - heavy_armature(model, j) * acceleration[j] for j in inputs.path}
    return Run(
        inputs.time,
        {j.name: qpos[:, j.qposadr[0]] for j in joints},
        {j.name: middle[:, j.dofadr[0]] for j in joints},
        acceleration,
        {**forces, **driven},
        record["sensordata"],
    )
