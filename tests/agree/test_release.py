"""Driven simulations against energy, the drives' own path and the reference's damping."""

from functools import cache
from pathlib import Path

import mujoco
import numpy as np
import pytest
from scipy.signal import find_peaks

from boom_mj.effects import make_effect
from boom_mj.errors import SimulationError
from boom_mj.machine import load_machine
from boom_mj.mjcf import build
from boom_mj.reference import ReferenceModel, Simplifications, integrate
from boom_mj.simulation import CATALOGUE, Plant, Trajectory, make_plant, run_experiment
from boom_mj.simulation.plant import with_effects

Array = np.ndarray
BOOM = load_machine(Path(__file__).parents[2] / "models" / "boom36.toml")
RELEASE = CATALOGUE["release_stretched_vertical"]
FREE = RELEASE.release + 0.05  # s: the rope's force is gone
STRETCHED = np.zeros(5)


@cache
def released(damped: bool) -> tuple[Plant, Trajectory]:
    undamped = BOOM.model_copy(
        update={
            "damping": BOOM.damping.model_copy(update={"relaxation_time": 0.0, "bending": 0.0, "torsion": 0.0}),
            "slewing": BOOM.slewing.model_copy(update={"viscous_friction": 0.0}),
            "link": tuple(link.model_copy(update={"viscous_friction": 0.0}) for link in BOOM.link),
        }
    )
    plant = make_plant(BOOM if damped else undamped, 1)
    return plant, run_experiment(plant, RELEASE)


def energy(plant: Plant, qpos: Array, qvel: Array) -> float:
    """Weight, springs and motion, J."""
    data = mujoco.MjData(plant.model)
    data.qpos[:], data.qvel[:] = qpos, qvel
    mujoco.mj_forward(plant.model, data)
    mujoco.mj_energyPos(plant.model, data)
    mujoco.mj_energyVel(plant.model, data)
    return float(data.energy.sum())


def test_energy_stays_after_the_cut_without_damping():
    plant, motion = released(damped=False)
    assert not plant.model.dof_damping.any()
    free = np.flatnonzero(motion.time > FREE)[::8]
    total = np.array([energy(plant, motion.qpos[k], motion.qvel[k]) for k in free])
    rest = plant.static_equilibrium(STRETCHED)
    stored = total[0] - energy(plant, rest, np.zeros(plant.model.nv))
    print(f"released {stored:.1f} J, drift {100 * np.abs(total - total[0]).max() / stored:.4f} %")
    assert stored > 50  # there is something to lose
    assert np.abs(total - total[0]).max() < 1e-3 * stored  # a symplectic step's ripple is (omega h)^2 of each mode


def test_drives_keep_their_path():
    experiment, plant = CATALOGUE["mixed"], make_plant(BOOM, 1)
    motion = run_experiment(plant, experiment)
    error = np.degrees(np.abs(motion.joints - experiment.joint_path(motion.time)[0])).max(axis=0)
    print(f"tracking error {error} deg")
    assert np.all(error < 1e-3)
    assert np.ptp(motion.joints, axis=0).min() > np.radians(1)  # every joint moves


def test_first_vertical_mode_decays_as_in_the_reference():
    plant, motion = released(damped=True)
    still = plant.tip(plant.static_equilibrium(STRETCHED))[2]
    late = motion.time > FREE + 4  # the next vertical mode has a third of the period and has lost e^-10 by then
    height = np.array([plant.tip(qpos)[2] for qpos in motion.qpos[late]]) - still
    peaks = find_peaks(height)[0]
    decrement = -np.polyfit(np.arange(peaks.size), np.log(height[peaks]), 1)[0]
    reference = ReferenceModel(BOOM)
    rest = reference.static_equilibrium(STRETCHED)
    modes = reference.modes(rest)
    vertical = [k for k in range(4) if np.argmax(np.abs(modes.shape[:, k]) * np.tile([0, 1, 1], 4)) % 3 == 1]
    ratio = modes.damping_ratio[vertical[0]]
    true = 2 * np.pi * ratio / np.sqrt(1 - ratio**2)
    print(f"decrement {decrement:.5f}, reference {true:.5f}, peaks {peaks.size}")
    assert peaks.size >= 6
    assert decrement == pytest.approx(true, rel=0.02)  # 1 % of frequency in 2 zeta = relaxation time x omega, doubled


def test_the_tip_goes_as_in_the_reference():
    """Within 2 % of the release, against finite rotations: 1.2 % in frequencies and 0.5 % in static deflection."""
    _, motion = released(damped=True)
    model = ReferenceModel(BOOM, Simplifications(linear_kinematics=False))
    time = np.arange(RELEASE.release - 0.02, RELEASE.release + 1.1, 0.02)  # half a period
    wanted = integrate(
        model,
        lambda t: (STRETCHED, STRETCHED, STRETCHED),
        lambda t: RELEASE.tip_force(np.array([t]))[0],
        time,
        1e-3,
    )
    tip = np.stack([np.interp(time, motion.time, column) for column in motion.sensor("marker12").T], axis=1)
    size = np.linalg.norm(model.tip(model.static_equilibrium(STRETCHED))[0] - wanted.tip[0])
    error = np.linalg.norm((tip - tip[0]) - (wanted.tip - wanted.tip[0]), axis=1).max() / size
    print(f"released by {size:.4f} m, apart by {100 * error:.2f} %")
    assert np.ptp(wanted.tip[:, 2]) > 1.5 * size  # it has swung to the other side
    assert error < 0.02


def test_simulations_break_where_steps_are_called_unstable():
    rest = RELEASE.model_copy(update={"duration": RELEASE.release + 2.0})
    for factor, holds in ((0.45, True), (0.35, False)):  # of the damping; the bound of steps of 10 ms lies at 0.39
        boom = build(BOOM, 2)
        boom.spec.option.timestep = 0.01
        plant = with_effects(boom, [make_effect("structural_damping", {"factor": factor})])
        assert plant.stable(np.zeros(plant.model.nq)) == holds
        if holds:
            run_experiment(plant, rest)
        else:
            with pytest.raises(SimulationError):
                run_experiment(plant, rest)


def test_a_play_that_nothing_holds_does_not_make_steps_unstable():
    effects = [make_effect("base_tilt", {"pitch": -0.006}), make_effect("joint_play", {"joint": 3, "half_gap": 0.003})]
    plant = make_plant(BOOM, 2, effects)
    q = np.zeros(plant.model.nq)
    assert np.linalg.eigvalsh(plant.stiffness(q)).min() < 0  # within the gap the weight tips the boom over
    assert plant.stable(q)
