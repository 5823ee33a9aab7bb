"""A force in time of no formula comes back, where it acts; the error of a sensor is no force."""

from collections.abc import Mapping

import numpy as np
import pytest

from boom_mj.diagnosis.clock import Clock
from boom_mj.diagnosis.linearisation import Linearisation, linearise
from boom_mj.discovery.forces import ForceInTime, forces_in_time
from boom_mj.effects import Effect, ForceEffect, Motion, make_effect
from boom_mj.machine import load_machine
from boom_mj.sensors import record
from boom_mj.simulation import CATALOGUE, make_plant, run_experiment
from boom_mj.systems.boom.system import BoomSystem
from boom_mj.systems.predictor import Predictor, dataset_of

PEAK_N, PEAK_S, WIDTH_S = 400.0, 4.0, 1.5


class Shove(ForceEffect):
    """Sideways on the tip, once."""

    id = "shove"

    def force(self, motion: Motion) -> Mapping[str, np.ndarray]:
        size, slew = PEAK_N * np.exp(-(((motion.time - PEAK_S) / WIDTH_S) ** 2)), motion.joints[:, 0]
        return {"tip": size[:, None] * np.stack([-np.sin(slew), np.cos(slew), 0 * slew], axis=1)}


def found(effect: Effect) -> tuple[Linearisation, tuple[ForceInTime, ...]]:
    """Of two recordings of ten seconds, one held out, from a plant of finer hinges."""
    experiment = CATALOGUE["release_bow_horizontal"].model_copy(update={"duration": 10.0, "release": 2.5})
    machine, rng = load_machine("boom36"), np.random.default_rng(0)
    plant, system = make_plant(machine, 6, (effect,)), BoomSystem(machine)
    logs = [record(run_experiment(plant, experiment), experiment, rng) for _ in range(2)]
    model = linearise(Predictor(system, dataset_of(system, logs, 1)))
    return model, forces_in_time(model, model.residual(model.base), Clock())


def test_a_shove_comes_back() -> None:
    _, forces = found(Shove())
    assert forces[0].place.acts_on == "the tip" and forces[0].closure.value > 0.8
    assert forces[0].closure.value > forces[2].closure.value + 0.1  # half a link away
    up, left = forces[0].force[1]
    true = PEAK_N * np.exp(-(((forces[0].time[1] - PEAK_S) / WIDTH_S) ** 2))
    inside = forces[0].time[1] < 9.0  # what comes later has not been felt yet
    assert left[0][inside] == pytest.approx(true[inside], abs=0.1 * PEAK_N)
    assert np.abs(up[0][inside]).max() < 0.1 * PEAK_N


def test_an_error_of_a_sensor_is_no_force() -> None:
    bias = make_effect("imu_bias", {"link": 4, "accelerometer_y": 0.5})
    _, forces = found(bias)
    assert max(force.closure.value for force in forces) < 0.1
