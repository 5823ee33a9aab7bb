"""Paths are smooth, the catalogue can be driven, what cannot is refused by name."""

from pathlib import Path

import numpy as np
import pytest

from boom_mj.errors import ExperimentError
from boom_mj.machine import load_machine
from boom_mj.simulation import CATALOGUE, Experiment, load_experiment, make_plant, smooth_angles, step_times

BOOM = load_machine(Path(__file__).parents[2] / "models" / "boom36.toml")


@pytest.mark.parametrize("name", CATALOGUE)
def test_velocity_and_acceleration_are_the_derivatives_of_the_path(name: str) -> None:
    experiment = CATALOGUE[name]
    experiment.check(BOOM)
    step = 1e-3
    time = np.arange(0, experiment.duration, step)
    angle, velocity, acceleration = experiment.joint_path(time)
    # central differences: error step^2 / 6 times the third derivative; a blend ends with a jump of jerk
    assert np.abs(np.gradient(angle, step, axis=0)[1:-1] - velocity[1:-1]).max() < 1e-4
    # where the jerk jumps, a central difference of the velocity is off by step / 2 times the jump
    assert np.abs(np.gradient(velocity, step, axis=0)[1:-1] - acceleration[1:-1]).max() < 2e-3
    assert np.degrees(angle[0]) == pytest.approx(experiment.pose_deg)


def test_moves_turn_by_their_angle_at_their_speed() -> None:
    slew = CATALOGUE["slew_t"]
    angle, velocity, _ = slew.joint_path(np.linspace(0, 30, 30001))
    assert np.degrees(angle[-1, 0]) == pytest.approx(6.0)
    assert np.degrees(velocity[:, 0].max()) == pytest.approx(2.0, rel=1e-6)
    moving = np.flatnonzero(velocity[:, 0] > 0)
    assert (moving[-1] - moving[0]) * 1e-3 == pytest.approx(4.0, abs=0.01)


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({"pose_deg": (0, 95, 0, 0, 0)}, ["joint2", "angle 95.00", "[-2, 88]"]),
        ({"move": [{"joint": 5, "start": 1, "angle_deg": -9, "speed_deg_s": 9}]}, ["joint5", "speed", "6"]),
    ],
)
def test_what_the_machine_cannot_follow_is_refused(change: dict, told: list[str]) -> None:
    base = {"name": "mine", "pose_deg": (0, 0, 0, 0, 0), "duration": 10}
    with pytest.raises(ExperimentError) as caught:
        Experiment.model_validate({**base, **change}).check(BOOM)
    assert all(part in str(caught.value) for part in told)


def test_own_experiments_come_from_toml(tmp_path: Path) -> None:
    file = tmp_path / "nod.toml"
    file.write_text(
        "pose_deg = [0, 10, 0, 0, 0]\nduration = 5\n[[move]]\njoint = 2\nstart = 1\nangle_deg = 1\nspeed_deg_s = 1\n"
    )
    nod = load_experiment(str(file))
    assert nod.name == "nod"
    assert np.degrees(nod.joint_path(np.array([5.0]))[0][0, 1]) == pytest.approx(11)
    file.write_text("pose = 1\n")
    with pytest.raises(ExperimentError, match="pose"):
        load_experiment(str(file))
    with pytest.raises(ExperimentError, match=r"slew_t.*\.toml"):
        load_experiment("slew")


def test_smoothing_gives_back_rest_and_motion() -> None:
    time, noise = np.arange(0, 30.01, 0.02), np.radians(0.02)
    wanted = CATALOGUE["slew_t"].joint_path(time)[0]
    noisy = wanted + np.random.default_rng(3).normal(size=wanted.shape) * noise
    fine = np.arange(0, 30, 0.005)
    smooth = smooth_angles(time, noisy, noise, fine)
    error = smooth - CATALOGUE["slew_t"].joint_path(fine)[0]
    resting = (fine < 2) | (fine > 9)
    assert error[resting].std() < noise / 8  # the mean of at least a hundred samples
    assert np.sqrt(np.mean(error[~resting, 0] ** 2)) < noise
    acceleration = np.diff(smooth[resting & (fine < 2)], 2, axis=0) / 0.005**2
    assert np.abs(acceleration).max() < 1e-4  # rad/s^2: at 32 m a sixth of an accelerometer's noise


def test_an_experiment_shorter_than_a_step_has_one() -> None:
    plant = make_plant(BOOM, 1)
    assert len(step_times(plant, 1e-308)) == 2
