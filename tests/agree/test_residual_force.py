"""The residual forces that a payload leaves, from where markers are, against its weight times the tip's Jacobian."""

from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np

from boom_mj.effects import make_effect
from boom_mj.estimation.noise import NoiseModel
from boom_mj.logs import read_log
from boom_mj.machine import load_machine
from boom_mj.recording import window
from boom_mj.simulation import make_plant
from boom_mj.systems.boom import BoomSystem
from boom_mj.systems.fidelity import Level
from boom_mj.systems.predictor import Predictor, dataset_of
from boom_mj.systems.system import ResidualForces

ROOT = Path(__file__).parents[2]
BOOM = load_machine(ROOT / "models" / "boom36.toml")
MASS = 20.0  # kg
ONE = Level(1.0)  # one hinge per coordinate, as the forces are told


def test_a_payload_asks_for_its_weight():
    log = read_log(ROOT / "logs" / "independent_release_stretched_vertical.mcap")
    held = replace(log, signals={name: window(signal, 0.0, 5.0) for name, signal in log.signals.items()})
    system = BoomSystem(BOOM)
    assert isinstance(system, ResidualForces)
    data = dataset_of(system, [held], 1)
    heavy, plain = Predictor(system, data, threads=1).predict([(make_effect("tip_payload", {"mass": MASS}),), ()], ONE)
    noise = NoiseModel(data, np.where(data.used, 1 / data.noise, 0.0), 0 * plain)
    white = noise.white(heavy - plain)
    found = {(p.part, p.direction): p for p in system.forces(data, white, noise.weight)}

    unplugged = data.spread([channel.group == "cylinder3" for channel in data.channels]).astype(bool)
    rest = system.forces(data, np.where(unplugged, 0.0, white), np.where(unplugged, 0.0, noise.weight))
    assert {(p.part, p.direction): p for p in rest} == {k: p for k, p in found.items() if k[0] != "cylinder3"}
    assert ("cylinder3", "force") in found

    plant = make_plant(BOOM, 1)
    turn = np.zeros((3, plant.model.nv))
    data = plant.at(plant.static_equilibrium(held["joint/position"].values[0]))
    mujoco.mj_jacSite(plant.model, data, turn, None, data.site("tip").id)
    world = data.site("world").xmat.reshape(3, 3)
    for (part, direction), force in found.items():
        if part.startswith("link"):
            column = plant.model.joint(f"{part}_{direction}_1").dofadr[0]
            weighs = abs(world[:, 2] @ turn[:, column]) * MASS * BOOM.gravity
            # the load bends the boom by another 10 mrad, which shifts its arms by that times their height, 3 m: 3 %
            assert abs(force.force - weighs) < 0.03 * weighs if direction == "v" else force.ratio < 0.5, (force, weighs)
    assert {part for part, direction in found if direction == "v"} == {"link2", "link3", "link4", "link5"}
