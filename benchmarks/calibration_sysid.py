"""The same problem for `boom_mj.calibration` and for MuJoCo's own system identification, in one run.

pip install "mujoco[sysid]"; python benchmarks/calibration_sysid.py

`mujoco.sysid` starts every simulation from a given state and takes one table of samples. So: boom36 without gravity (it
rests straight, whatever its stiffness), the T-shaped pose, joint 1 moves and stops, IMUs with noise; unknown are E_z of
the four links and the damping. Both have the same model, joint angles and noise, one thread.
"""

import time
from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
from mujoco import sysid

from boom_mj.calibration.evidence import MIDDLE, predictor_of
from boom_mj.calibration.parameters import Parameterisation, make_parameterisation
from boom_mj.calibration.refine import refine
from boom_mj.effects.spec_edits import elastic_hinges, link_hinges
from boom_mj.estimation.noise import noise_model
from boom_mj.machine import load_machine
from boom_mj.mjcf import build
from boom_mj.recording import Recording
from boom_mj.sensors import driving_angles, noise_levels, record
from boom_mj.simulation import CATALOGUE, make_plant, run_experiment, step_times
from boom_mj.simulation.simulate import ARMATURE, SERVO

Array = np.ndarray
BOOM = load_machine(Path(__file__).parents[1] / "models" / "boom36.toml").model_copy(update={"gravity": 0.0})
KINDS = ("youngs_modulus_z", "damping")
TRUTH = np.log([0.9, 1.15, 0.85, 1.1, 1.5])
LINKS = (2, 3, 4, 5)
HINGES = MIDDLE.hinges


def recording(free: Parameterisation) -> Recording:
    """IMUs of the true machine, with noise."""
    plan = CATALOGUE["slew_t"]
    motion = run_experiment(make_plant(free.at(TRUTH).machine, HINGES), plan)
    log = record(motion, plan, np.random.default_rng(0))
    kept = {n: s for n, s in log.signals.items() if n.startswith(("imu", "joint", "load"))}
    return Recording(log.name, log.machine, log.description, kept)


def driven_spec() -> mujoco.MjSpec:
    """The model whose joints follow their reference; as `simulation.driven_model`, before compilation."""
    spec = build(BOOM, HINGES).spec
    spec.option.disableflags |= mujoco.mjtDisableBit.mjDSBL_LIMIT | mujoco.mjtDisableBit.mjDSBL_CONTACT
    for k in range(1, 6):
        spec.joint(f"joint{k}").armature = ARMATURE
        drive = spec.actuator(f"drive{k}")
        drive.gainprm[0], drive.biasprm[:3] = ARMATURE * SERVO**2, (0, -ARMATURE * SERVO**2, 0)
        drive.ctrllimited = False
    return spec


def stiffen(link: int):
    """A modifier: E_z of a link times the parameter; damping goes with it, as in boom_mj."""

    def modify(spec: mujoco.MjSpec, parameter: "sysid.Parameter") -> None:
        for hinge in link_hinges(spec, link, "w"):
            hinge.stiffness = hinge.stiffness * parameter.value[0]
            hinge.damping = hinge.damping * parameter.value[0]

    return modify


def damp(spec: mujoco.MjSpec, parameter: "sysid.Parameter") -> None:
    """A modifier: all damping times the parameter."""
    for hinge in elastic_hinges(spec, BOOM):
        hinge.damping = hinge.damping * parameter.value[0]


def fresh(params: "sysid.ParameterDict", spec: mujoco.MjSpec) -> mujoco.MjModel:
    """The model at some parameters; modifiers that multiply need a spec that none has touched."""
    return sysid.apply_param_modifiers(params, spec.copy())


def by_sysid(log: Recording) -> Array:
    """Logarithms of the factors."""
    spec, plant = driven_spec(), make_plant(BOOM, HINGES)
    model, joints = spec.compile(), log["joint/position"]
    steps = step_times(plant, joints.time[-1] - joints.time[0])
    angles = driving_angles(log, noise_levels(BOOM)["joint/position"][0], steps + joints.time[0])
    path = np.vstack([2 * angles[0] - angles[1], angles, 2 * angles[-1] - angles[-2]])
    speed = np.diff(path, axis=0) / model.opt.timestep
    control = np.zeros((len(steps), model.nu))
    control[:, [model.actuator(f"drive{k}").id for k in range(1, 6)]] = (
        angles + np.diff(speed, axis=0) / model.opt.timestep / SERVO**2
    )
    data = mujoco.MjData(model)
    data.qpos[plant.joints], data.qvel[plant.joints] = angles[0], speed[0]
    names = [name for name in log.signals if name.startswith("imu")]
    level = np.concatenate([noise_levels(BOOM)[name] for name in names])
    measured = np.hstack([log[name].values for name in names])
    sensors = [f"{'accelerometer' if 'force' in name else 'gyro'}_{name.split('/')[1]}" for name in names]
    columns = np.concatenate([np.arange(a := model.sensor(s).adr[0], a + 3) for s in sensors])
    gyro = np.repeat(["gyro" in s for s in sensors], 3)
    time_of = log[names[0]].time - joints.time[0]

    def residual(params, predicted, truth, model, full, state=None):
        found = predicted.data[:, columns]
        found[:-1, gyro] = (found[:-1, gyro] + found[1:, gyro]) / 2  # rates lie half a step back
        at = model.opt.timestep * np.arange(len(found))
        inside = time_of <= at[-1]
        twin = np.stack([np.interp(time_of[inside], at, column) for column in found.T], axis=1)
        return ((twin - measured[inside]) / level).ravel(), predicted, predicted

    params = sysid.ParameterDict()
    for link in LINKS:
        params.add(sysid.Parameter(f"E_z {link}", 1.0, 0.25, 4.0, modifier=stiffen(link)))
    params.add(sysid.Parameter("damping", 1.0, 0.25, 4.0, modifier=damp))
    state = sysid.create_initial_state(model, data.qpos, data.qvel, data.act)
    table = np.zeros((len(steps), model.nsensordata))
    sequences = sysid.ModelSequences(
        "boom", spec, "slew", state, sysid.TimeSeries(steps, control), sysid.TimeSeries.from_names(steps, table, model)
    )
    misfit = sysid.build_residual_fn(
        models_sequences=[sequences], build_model=fresh, modify_residual=residual, n_threads=1
    )
    found, _ = sysid.optimize(params, misfit, optimizer="mujoco", verbose=False)
    return np.log([found[name].value[0] for name in found.keys()])  # noqa: SIM118


def main() -> None:
    """Both, and what they found."""
    if not hasattr(sysid, "Parameter"):
        raise SystemExit('mujoco.sysid is empty without its extras: pip install "mujoco[sysid]"')
    free = replace(make_parameterisation(BOOM, KINDS), joints=0)
    log = recording(free)
    began = time.perf_counter()
    predictor = predictor_of(BOOM, [log], threads=1)
    same = np.zeros(len(predictor.data.time))  # no correction for finer hinges: both have the model that made the data
    refined = refine(predictor, free, np.zeros(free.size), (same, noise_model(predictor.data, same, 0.0)))
    middle = time.perf_counter()
    theirs = by_sysid(log)
    end = time.perf_counter()
    print(
        "| factor | true | boom_mj | its deviation | mujoco.sysid | difference, deviations |\n|---|---|---|---|---|---|"
    )
    for k, name in enumerate(free.names[: len(free.tied)]):
        ours, deviation = refined.scaled[k], refined.deviation[k]
        apart = (theirs[k] - ours) / deviation
        cells = f"{np.exp(TRUTH[k]):.4f} | {np.exp(ours):.4f} | {deviation:.4f} | {np.exp(theirs[k]):.4f}"
        print(f"| {name} | {cells} | {apart:+.2f} |")
    print(f"\nboom_mj {middle - began:.1f} s, mujoco.sysid {end - middle:.1f} s:", end=" ")
    print(f"ratio {(end - middle) / (middle - began):.2f}")


if __name__ == "__main__":
    main()
