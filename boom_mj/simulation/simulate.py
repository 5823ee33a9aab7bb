"""Prescribed joint motion and rope loads, integrated by MuJoCo without Python in the loop.

Drives: every joint carries a huge armature A and a servo of frequency omega whose reference is fed forward,
u = q_ref + qdd_ref / omega^2, so that the boom cannot push it off its path: the tracking error is torque / (A omega^2).
What the servo exerts beyond accelerating A is the drive torque.
"""

from copy import copy
from dataclasses import dataclass
from functools import cached_property

import mujoco
import numpy as np
from mujoco.batch import Batch

from boom_mj.effects import ForceEffect, Motion
from boom_mj.errors import InputError
from boom_mj.machine import cylinder_forces
from boom_mj.recording.names import JOINTS as JOINT_NAMES
from boom_mj.simulation.diverged import diverged
from boom_mj.simulation.experiments import LONGEST, Experiment
from boom_mj.simulation.plant import JOINTS, Plant

Array = np.ndarray
ARMATURE = 1e11  # kg m^2, five orders above the boom's own inertia
MOST_STEPS = 2**21  # some gigabytes of states
SERVO = 2 * np.pi * 2.0  # rad/s


@dataclass(frozen=True)
class Trajectory:
    """A simulated motion, sampled at every step.

    Attributes:
        plant: what moved.
        time: (n,), s.
        joints: q1..q5, (n, 5), rad.
        qpos: (n, nq).
        qvel: centred at `time` - the integrator's own lie half a step earlier -, (n, nv).
        joint_torque: drive torques, (n, 5), N m.
        tip_force: rope force, (n, 3), N.
        sensordata: ideal sensors of the model, (n, nsensordata).
    """

    plant: Plant
    time: Array
    joints: Array
    qpos: Array
    qvel: Array
    joint_torque: Array
    tip_force: Array
    sensordata: Array

    def sensor(self, name: str) -> Array:
        """One sensor of the model, (n, dim)."""
        sensor = self.plant.model.sensor(name)
        return self.sensordata[:, sensor.adr[0] : sensor.adr[0] + sensor.dim[0]]

    @cached_property
    def ritz(self) -> Array:
        """Elastic Ritz coordinates, (n, 12), rad and m."""
        return self.qpos @ self.plant.ritz.T

    @property
    def cylinder_force(self) -> Array:
        """Forces of cylinders 2 and 3, (n, 2), N."""
        return cylinder_forces(self.plant.machine, self.joints, self.joint_torque)


def driven_model(plant: Plant, loaded: bool = True) -> mujoco.MjModel:
    """A copy of the plant's model whose joints follow their reference whatever the boom does.

    Args:
        loaded: whether the rope pulls; MuJoCo spends a twentieth of a step on where it pulls.
    """
    model = copy(plant.model)
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_LIMIT | mujoco.mjtDisableBit.mjDSBL_CONTACT
    if not (model.neq or model.dof_frictionloss.any() or model.tendon_frictionloss.any()):
        model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
    model.dof_armature[plant.joints] = ARMATURE
    for k in range(JOINTS):
        drive = model.actuator(f"drive{k + 1}")
        drive.gainprm[0], drive.biasprm[:3] = ARMATURE * SERVO**2, (0, -ARMATURE * SERVO**2, 0)
        drive.ctrllimited = False
    if not loaded:  # the rope hangs on a joint that it cannot turn
        rope = _rope(model)
        model.actuator_trntype[rope], model.actuator_trnid[rope] = mujoco.mjtTrn.mjTRN_JOINT, (0, -1)
        model.actuator_gear[rope] = 0
    mujoco.mj_setConst(model, mujoco.MjData(model))
    return model


def _rope(model: mujoco.MjModel) -> list[int]:
    return [model.actuator(f"rope_{axis}").id for axis in "xyz"]


def run_experiment(plant: Plant, experiment: Experiment) -> Trajectory:
    """Simulate an experiment from rest.

    Raises:
        InputError: the machine cannot follow it, or it is too long.
        SimulationError: MuJoCo diverged.
    """
    time = step_times(plant, experiment.duration)
    experiment.check(plant.machine)
    return run(plant, experiment.joint_path(time)[0], experiment.tip_force(time))


def step_times(plant: Plant, duration: float) -> Array:
    """Times of the integrator's steps from 0 to past `duration`, (n,), s.

    Raises:
        InputError: it is longer than LONGEST.
    """
    step = plant.model.opt.timestep
    if duration > min(LONGEST, MOST_STEPS * step):
        raise InputError(
            f"{duration:.6g} s are too long for one simulation of {plant.machine.name}: up to {LONGEST:g} s and "
            f"{MOST_STEPS} steps, here of {step:.3g} s, are simulated"
        )
    return step * np.arange(max(int(np.ceil(duration / step - 1e-9)), 1) + 1)


def run(plant: Plant, angles: Array, tip_force: Array) -> Trajectory:
    """Simulate a joint motion given at every step, from static equilibrium.

    Args:
        angles: q1..q5 at the steps, (n, 5), rad.
        tip_force: world frame, (n, 3), N.

    Raises:
        SimulationError: the state is no longer finite; when and where, and the last states.
    """
    model, step = driven_model(plant, bool(np.any(tip_force))), plant.model.opt.timestep
    path = np.vstack([2 * angles[0] - angles[1], angles, 2 * angles[-1] - angles[-2]])
    speed = np.diff(path, axis=0) / step  # (n + 1, 5): half a step before and after each time
    control = np.zeros((len(angles), model.nu))
    drives = [model.actuator(f"drive{k + 1}").id for k in range(JOINTS)]
    control[:, drives] = angles + np.diff(speed, axis=0) / step / SERVO**2
    control[:, _rope(model)] = tip_force
    pushes = _pushes(plant, step * np.arange(len(angles)), angles)
    for site, force in pushes.items():
        control[:, [model.actuator(f"push_{site}_{axis}").id for axis in "xyz"]] = force

    batch = Batch(model, 1, 1)
    at_start = {site: force[0] for site, force in pushes.items()}
    batch.qpos[0] = start = plant.static_equilibrium(angles[0], tip_force[0], at_start)
    if model.nplastic:
        batch.plastic[0] = plant.scratch.plastic
    batch.qvel[0] = 0
    batch.qvel[0, plant.joints] = speed[0]
    # recorded states lie after each step, all that derives from them before it
    qpos, qvel = np.empty((1, len(angles) + 1, model.nq)), np.empty((1, len(angles) + 1, model.nv))
    qpos[0, 0], qvel[0, 0] = start, batch.qvel[0]
    states = {"qpos": qpos[:, 1:], "qvel": qvel[:, 1:]}
    record = batch.rollout(
        len(angles), control[None], record=(*states, "qacc", "sensordata", "actuator_force"), out=states
    )
    warned = batch.warning[0]
    if not np.all(np.isfinite(qpos[0, -1])) or warned.any():
        raise diverged(model, qpos[0], qvel[0], warned, plant.machine.name)

    centred = qvel[0, :-1]
    centred += qvel[0, 1:]
    centred /= 2
    torque = record["actuator_force"][0][:, drives] - ARMATURE * record["qacc"][0][:, plant.joints]
    return Trajectory(
        plant=plant,
        time=step * np.arange(len(angles)),
        joints=qpos[0, :-1, plant.joints].T,
        qpos=qpos[0, :-1],
        qvel=centred,
        joint_torque=torque,
        tip_force=np.asarray(tip_force),
        sensordata=_centre_gyros(model, record["sensordata"][0]),
    )


def _pushes(plant: Plant, time: Array, joints: Array) -> dict[str, Array]:
    """Forces of all the plant's effects, by site, (n, 3), N."""
    total: dict[str, Array] = {}
    motion = Motion(time, dict(zip(JOINT_NAMES, joints.T)), machine=plant.machine)
    for effect in plant.effects:
        if isinstance(effect, ForceEffect):
            for site, force in effect.force(motion).items():
                total[site] = total.get(site, 0.0) + force
    return total


def _centre_gyros(model: mujoco.MjModel, data: Array) -> Array:
    """Angular rates come from velocities half a step old: average them with the next, in place."""
    for k in np.flatnonzero(model.sensor_type == mujoco.mjtSensor.mjSENS_GYRO):
        rate = slice(model.sensor_adr[k], model.sensor_adr[k] + 3)
        data[:-1, rate] = (data[:-1, rate] + data[1:, rate]) / 2
    return data
