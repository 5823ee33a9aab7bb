"""Chains of equivalent hinges against the beam FE, both linear: loads so small that deflections are of millimetres.

Link shapes depend on ratios of loads alone, so a thousandth of the weight leaves the chains as they are.
"""

from functools import cache
from pathlib import Path

import numpy as np
import pytest
from beam_fe import BeamModel, beam_model

from boom_mj.machine import Machine, load_machine
from boom_mj.simulation import Plant, make_plant

Array = np.ndarray
BOOM = load_machine(Path(__file__).parents[2] / "models" / "boom36.toml")
SMALL = 1e-3  # of the weight: second-order terms are 4e-5 of the deflection (an arc's shortening at 1.9 mm in 32 m)
LOADS = {
    "own weight": (0.0, 0.0, 0.0),
    "force down": (0.0, 0.0, -981.0 * SMALL),
    "force sideways": (0.0, 981.0 * SMALL, 0.0),
}
LOW, HIGH = np.array([drive.range for drive in BOOM.drives]).T
POSES = {
    "stretched": np.zeros(5),
    "bow": np.radians([0.0, 60.0, -35.0, -40.0, -45.0]),
    **{f"random{k}": np.random.default_rng([7, k]).uniform(LOW, HIGH) for k in range(3)},
}
STATIC, MODAL = 5e-3, 1e-2  # what four hinges per coordinate are promised to reach


def changed(kind: str, gravity: float) -> Machine:
    profile = BOOM.offset_profile.model_copy(update={"kind": kind})
    return BOOM.model_copy(update={"offset_profile": profile, "gravity": gravity})


@cache
def plant(kind: str, hinges: int, weight: bool) -> Plant:
    return make_plant(changed(kind, BOOM.gravity * SMALL * weight), hinges)


@cache
def beam(kind: str, pose: str) -> BeamModel:
    return beam_model(changed(kind, BOOM.gravity * SMALL), POSES[pose])


def straight(model: Plant, pose: str) -> Array:
    qpos = np.zeros(model.model.nq)
    qpos[model.joints] = POSES[pose]
    return qpos


def deflection_error(kind: str, pose: str, load: str, hinges: int) -> float:
    """Distance of the two tips over the FE's deflection; a tip force acts on the weightless boom.

    In the random poses, most of them folded, the deflections of the links nearly cancel at the tip; there the distance
    is taken over the deflection of the stretched boom.
    """
    weight, force = load == "own weight", np.array(LOADS[load], float)
    model = plant(kind, hinges, weight)
    moved = model.tip(model.static_equilibrium(POSES[pose], force)) - model.tip(straight(model, pose))
    true = beam(kind, pose).tip_displacement(force, gravity=weight)
    size = true if pose in ("stretched", "bow") else beam(kind, "stretched").tip_displacement(force, gravity=weight)
    return float(np.linalg.norm(moved - true) / np.linalg.norm(size))


def frequency_errors(kind: str, pose: str, hinges: int, count: int) -> Array:
    """Relative, of the modes about the unloaded straight links."""
    model = plant(kind, hinges, False)
    true = beam(kind, pose).modes(count)[0]
    return model.modes(straight(model, pose)).frequency[:count] / true - 1


@pytest.mark.parametrize("kind", ["ramp", "step"])
@pytest.mark.parametrize("load", LOADS)
@pytest.mark.parametrize("pose", POSES)
def test_four_hinges_deflect_like_the_beam(kind, load, pose):
    error = deflection_error(kind, pose, load, 4)
    assert error < STATIC, f"{np.degrees(POSES[pose]).round(1)} deg: {100 * error:.3f} % under {load}"


@pytest.mark.parametrize("kind", ["ramp", "step"])
@pytest.mark.parametrize("pose", POSES)
def test_hinges_vibrate_like_the_beam(kind, pose):
    """Four hinges do in the experiments' poses; folded up, where links swing against each other, it takes eight."""
    hinges = 4 if pose in ("stretched", "bow") else 8
    error = frequency_errors(kind, pose, hinges, 6)
    assert np.all(np.abs(error) < MODAL), f"{np.degrees(POSES[pose]).round(1)} deg: {(100 * error).round(3)} %"


@pytest.mark.parametrize("kind", ["ramp", "step"])
@pytest.mark.parametrize("what", ["f1", "f2", *LOADS])
def test_hinges_converge_to_the_beam_with_second_order(kind, what):
    counts = np.array([2, 4, 8, 16])
    if what in LOADS:
        errors = np.array([deflection_error(kind, "stretched", what, n) for n in counts])
    else:
        errors = np.array([abs(frequency_errors(kind, "stretched", n, 2)[int(what[1]) - 1]) for n in counts])
    order = -np.polyfit(np.log(counts), np.log(errors), 1)[0]
    assert order >= 1.5, f"order {order:.2f}: errors {(100 * errors).round(4)} % with {counts} hinges"
