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
}


def log(name: str) -> Path:
    path = REAL / name
    if not path.exists():
        pytest.skip(f"{name} is not at {REAL}; BOOM_MJ_REAL says where recordings of real machines are")
    return path


def map_of(name: str) -> Path:
    return ROOT / "models" / "real" / f"{name}.toml"


@cache
def answer(name: str, *held_out: str) -> dict[str, Any]:
    system, data = load_mjcf([log(LOGS[name])], [log(other) for other in held_out], map_of(name))
    return document(diagnose(Predictor(system, data)), [part.name for part in data.recordings])


def causes(found: dict[str, Any]) -> list[dict[str, Any]]:
    """All of the best explanation: those that are sure, and those that are suspected beside them."""
    return [*found["effects"], *found["suspect"]]


def sizes(found: dict[str, Any], name: str) -> dict[str, float]:
    effects = [effect for effect in causes(found) if effect["id"] == name]
    return {parameter: size["value"] for parameter, size in effects[0]["parameters"].items()} if effects else {}


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
    """Janot, Gautier, Brunot 2019 by their inverse model: 203.5 N s/m, 20.4 N, offset -3.2 N, mass 95.1 kg.

    Viscous friction that differs between the directions stands for the offset at the speed of most of the log.
    """
    found = answer("emps")
    friction = {**sizes(found, "dry_and_viscous_friction"), **sizes(found, "directional_friction")}
    damping = [friction.get(way, friction.get("damping", np.nan)) for way in ("forward", "backward")]
    assert np.mean(damping) == pytest.approx(203.5, rel=0.1)
    assert friction["force"] == pytest.approx(20.4, rel=0.1)
    system, _ = load_mjcf([log(LOGS["emps"])], [], map_of("emps"))
    (speed,) = (site.speed for site in system.sites() if site.location == {"joint": "slide"})
    offset = sizes(found, "actuator_bias").get("offset", 0.0) + (damping[1] - damping[0]) * speed / 2
    assert offset == pytest.approx(3.2, rel=0.2)  # against their friction's sign
    assert found["gap"]["closure"] > 0.9


@pytest.mark.slow
def test_the_beam_is_as_stiff_as_its_owners_say_and_lacks_damping() -> None:
    """Their Young's modulus stands; another release, not learnt from, falls silent the same way."""
    found = answer("clamped_beam", "clamped_beam/beam_gravity_V2_b.csv.gz")
    assert [effect["id"] for effect in found["effects"]] == ["link_damping"]
    assert found["gap"]["closure"] > 0.9


@pytest.mark.slow
@pytest.mark.xfail(strict=True, reason="a gain of the motor in its place leaves less of the held-out gap, 1.4 for 1.7")
def test_the_hub_has_the_friction_that_steady_speeds_tell() -> None:
    """`scope_data_deadzone_pos.mat`: 0.445 rad/s at 0.45 V, 1.628 rad/s at 1.1 V, so 0.21 V and 0.55 V s/rad."""
    hub = sizes_at_hub(answer("flexible_joint"), "dry_and_viscous_friction")
    assert hub, "no dry friction is named at the hub"
    force, damping = hub["force"], hub["damping"]
    assert force["low"] < 0.21 < force["high"]
    assert damping["low"] < 0.55 - 0.87 < damping["high"]  # the nominal model has 0.87


@pytest.mark.slow
def test_the_hub_needs_the_voltage_that_steady_speeds_tell() -> None:
    """The same log at 1 rad/s, about as fast as the hub is: dry and viscous friction and the motor's gain together."""
    found = answer("flexible_joint")
    named = [sizes_at_hub(found, kind) for kind in ("dry_and_viscous_friction", "viscous_joint_friction")]
    more = sum(size["value"] for effect in named for size in effect.values())  # V, and V s/rad at 1 rad/s
    gain = sizes(found, "actuator_gain").get("factor", 1.0)
    assert (0.87 + more) / gain == pytest.approx(0.21 + 0.55, rel=0.1)  # nominally 0.87, which is 14 % too much
    assert sizes(found, "sprung_inertia")["factor"] > 10
    assert found["gap"]["closure"] > 0.9


def sizes_at_hub(found: dict[str, Any], name: str) -> dict[str, Any]:
    effects = [e for e in causes(found) if (e["id"], e["location"]) == (name, {"joint": "hub"})]
    return effects[0]["parameters"] if effects else {}
