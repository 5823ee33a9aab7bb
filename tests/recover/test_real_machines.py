"""Machines that exist, measured by others: what is named agrees with what is known of them another way.

The data are no part of the project: `BOOM_MJ_REAL`, or ../shared/real beside it, is where they lie.
"""

import os
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from boom_mj.diagnosis import diagnose, document
from boom_mj.systems.mjcf import load_channel_map, load_mjcf
from boom_mj.systems.predictor import Predictor

ROOT = Path(__file__).parents[2]
REAL = Path(os.environ.get("BOOM_MJ_REAL", ROOT.parent / "shared" / "real"))
LOGS = {
    "emps": "emps/DATA_EMPS.mat",
    "two_link_arm": "two_link_arm/lqr_full_10deg.mat",
    "clamped_beam": "clamped_beam/beam_gravity_V2_a.csv.gz",
    "flexible_joint": "flexible_joint/scope_data_PRBS.mat",
    "so101": "so101/friction_gravity/state_motor.csv.gz",
    "friction_damper": "friction_damper/sine_1Hz_25lb.csv",
    "simple_pendulum": "simple_pendulum/energy_shaping.csv",
}


def log(name: str) -> Path:
    path = REAL / name
    if not path.exists():
        pytest.skip(f"{name} is not at {REAL}; BOOM_MJ_REAL says where recordings of real machines are")
    return path


def map_of(name: str) -> Path:
    return ROOT / "models" / "real" / f"{name}.toml"


@cache
def answer(name: str, *held_out: str, more: tuple[str, ...] = ()) -> dict[str, Any]:
    logs = [log(LOGS[name]), *(log(other) for other in more)]
    system, data = load_mjcf(logs, [log(other) for other in held_out], map_of(name))
    return document(diagnose(Predictor(system, data)), [part.name for part in data.recordings])


@pytest.mark.parametrize("name", LOGS)
def test_maps_fit_their_models_and_logs(name: str) -> None:
    """Every set is simulated from its nominal model; its gap is there to be explained."""
    system, data = load_mjcf([log(LOGS[name])], [], map_of(name))
    (nominal,) = Predictor(system, data).predict([()], system.facts.fidelity.middle, data.trained)
    misses = ((data.measured - nominal) / data.noise)[data.train]
    assert 1 < float((misses**2).mean() ** 0.5) < 1e3
    assert {channel.signal for channel in data.channels} == {
        entry.name for entry in load_channel_map(map_of(name)).role("compare")
    }


@pytest.mark.slow
def test_the_drive_has_the_friction_that_its_owners_found() -> None:
    """Janot, Gautier, Brunot 2019: 167 and 240 N s/m by direction, 20 N dry; 2.6 % of the force is left."""
    found = answer("emps")
    assert found["verdict"] == "partial"
    friction = intervals(found, "directional_friction", joint="slide")
    for name, published in (("forward", 167.0), ("backward", 240.0), ("force", 20.0)):
        assert friction[name]["low"] < published < friction[name]["high"], name
        assert friction[name]["value"] == pytest.approx(published, rel=0.06), name
    assert found["gap"]["holdout"]["after"] * 0.2515 / 52.4 < 0.026  # noise of a block and rms of what is held out, N


@pytest.mark.slow
def test_six_joints_stick_at_rest_and_on_the_way() -> None:
    """Friction of all of them in one answer, and at most half of the 29 of 93 that were left when three were named."""
    found = answer("so101", "so101/step_response/state_motor.csv.gz")
    rubbing = {effect["location"].get("joint") for effect in found["effects"] if effect["id"].endswith("friction")}
    assert {"elbow", "pitch", "wrist_pitch"} <= rubbing
    assert found["gap"]["holdout"]["after"] < 0.5 * 29 / 93 * found["gap"]["holdout"]["before"]


@pytest.mark.slow
def test_the_damper_has_play_and_elasticity_before_its_friction() -> None:
    """By eye at reversals: 3 to 4 mm without force, about 6 kN/mm to and from it."""
    found = answer("friction_damper", "friction_damper/sine_0.5Hz_25lb.csv")
    play = intervals(found, "friction_behind_play", joint="slide")
    assert 3e-3 < 2 * play["half_gap"]["value"] < 4e-3
    assert play["stiffness"]["low"] < 6e6 < play["stiffness"]["high"]
    assert found["gap"]["holdout"]["after"] < 0.45 * found["gap"]["holdout"]["before"]


@pytest.mark.slow
def test_of_the_pendulum_friction_alone_is_sure() -> None:
    """Published, from a rig: 0.184 N m dry; what acts beside it the data do not tell."""
    held_out = ("simple_pendulum/sac.csv", "simple_pendulum/direct_collocation.csv")
    found = answer("simple_pendulum", *held_out, more=("simple_pendulum/ddp.csv",))
    (effect,) = found["effects"]
    assert effect["id"].endswith("friction") and effect["location"] == {"joint": "shaft"}
    assert effect["parameters"]["force"]["low"] < 0.184 < effect["parameters"]["force"]["high"]


@pytest.mark.slow
def test_the_beam_is_as_stiff_as_its_owners_say_and_lacks_damping() -> None:
    """Their Young's modulus stands within 3 %; another release, not learnt from, falls silent the same way."""
    found = answer("clamped_beam", "clamped_beam/beam_gravity_V2_b.csv.gz")
    damping = intervals(found, "link_damping", link="beam")["relaxation_time"]
    assert 2e-3 < damping["low"] < damping["value"] < damping["high"] < 4e-3  # s
    spring = {"link_stiffness", "link_density"}  # the tone tells their ratio alone
    assert {effect["id"] for effect in found["effects"]} <= {"link_damping", "relaxing_stiffness", *spring}
    for effect in found["effects"]:
        if effect["id"] in spring:
            assert effect["parameters"]["factor"]["value"] == pytest.approx(1, abs=0.03)
    assert found["gap"]["holdout"]["after"] < 2


@pytest.mark.slow
def test_the_hub_has_the_friction_that_steady_speeds_tell() -> None:
    """`scope_data_deadzone_pos.mat`: 0.445 rad/s at 0.45 V, 1.628 rad/s at 1.1 V, by whatever form of friction."""
    steps, square = (f"flexible_joint/scope_data_{name}.mat" for name in ("deadzone_pos", "square"))
    found = answer("flexible_joint", square, more=(steps,))
    hub = [e for e in found["effects"] if e["location"] == {"joint": "hub"}]
    assert hub and all(e["id"].endswith("friction") for e in hub)

    def voltage(speed: float) -> float:
        total = 0.87 * speed  # of the nominal model
        for effect in hub:
            size = {name: one["value"] for name, one in effect["parameters"].items()}
            total += size.get("force", 0.0) + size.get("forward", size.get("damping", 0.0)) * speed
            total += size.get("excess", 0.0) * np.exp(-((speed / size.get("speed", 1.0)) ** 2))
        return float(total)

    assert voltage(0.445) == pytest.approx(0.45, rel=0.1) and voltage(1.628) == pytest.approx(1.1, rel=0.1)


def intervals(found: dict[str, Any], name: str, **location: str) -> dict[str, Any]:
    """Parameters of a named effect."""
    here = [e["parameters"] for e in found["effects"] if e["id"] == name and e["location"] == location]
    assert here, f"{name} at {location} is not named: {found['sentence']}"
    return dict(here[0])
