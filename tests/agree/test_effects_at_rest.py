"""What effects do to the stretched boom at rest, against statics by hand: weight, inertia, and how far it gives."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from boom_mj.effects import ForceEffect, Motion, parse_effect
from boom_mj.effects.library.joint_play import GIVES, flank_stiffness
from boom_mj.machine import load_machine, with_values
from boom_mj.simulation import Plant, make_plant

BOOM = load_machine(Path(__file__).parents[2] / "models" / "boom36.toml")
LENGTHS = np.array([link.length for link in BOOM.links])
ROOTS = np.array([0.0, *np.cumsum(LENGTHS)[:-1]])  # x of joints 2 to 5, m
REACH, HEIGHT = float(LENGTHS.sum()), BOOM.slewing.pivot_height
STRETCHED = np.zeros(5)
FORCE = 10.0  # N, so little that all ways are linear
WEIGHTLESS = with_values(BOOM, {"gravity": 1e-6})
LINE = 0.4 * BOOM.delivery_pipe.mass_per_length_concrete  # kg/m

MASSES: dict[str, Sequence[tuple[float, float, float]]] = {  # from x to x, kg
    "tip_payload:mass=80": [(REACH, REACH, 80)],
    "end_hose:mass=60": [(REACH, REACH, 60)],
    "pipe_concrete:fill=0.4": [(0, REACH, LINE * REACH)],
    "link_mass:link=4,factor=1.2": [(*2 * (ROOTS[3] + BOOM.links[2].center_of_gravity,), 0.2 * BOOM.links[2].mass)],
}
WAYS = {  # direction of a force on the tip, and how far the tip goes with it beyond the healthy boom's, m
    "hydraulic_compliance:joint=2,stiffness=2e7": ("z", FORCE * REACH**2 / 2e7),
    "hydraulic_compliance:joint=3,stiffness=2e7": ("z", FORCE * (REACH - ROOTS[1]) ** 2 / 2e7),
    "base_compliance:axes=pitch,pitch=1e8": ("z", FORCE * REACH**2 / 1e8),
    "base_compliance:axes=roll,roll=1e8": ("y", FORCE * HEIGHT**2 / 1e8),
    "slew_compliance:stiffness=1e7": ("y", FORCE * REACH**2 / 1e7),
    "slew_backlash:half_gap=0.004": ("y", 0.004 * REACH + FORCE * REACH**2 / flank_stiffness(BOOM, 1)),
    "joint_play:joint=4,half_gap=0.002": (
        "z",
        0.002 * (REACH - ROOTS[2]) + FORCE * (REACH - ROOTS[2]) ** 2 / flank_stiffness(BOOM, 4),
    ),
}


def torques_and_inertia(plant: Plant) -> tuple[np.ndarray, float]:
    """Torques of the joints, N m, and inertia about the slewing axis, kg m^2, of the boom without any sag."""
    straight = np.zeros(plant.model.nq)
    return plant.static_torques(straight), float(plant.mass_matrix(straight)[plant.joints[0], plant.joints[0]])


@pytest.mark.parametrize("hinges", [1, 3])
@pytest.mark.parametrize("effect", MASSES)
def test_masses_pull_and_turn_where_they_are(effect: str, hinges: int) -> None:
    plant, healthy = (make_plant(BOOM, hinges, effects) for effects in ([parse_effect(effect)], []))
    masses = MASSES[effect]
    torques, inertia = zip(*map(torques_and_inertia, (plant, healthy)))
    for joint, root in enumerate(ROOTS):
        outboard = [(max(start, root), stop, mass * _share(start, stop, root)) for start, stop, mass in masses]
        wanted = BOOM.gravity * sum(mass * ((start + stop) / 2 - root) for start, stop, mass in outboard)
        assert torques[0][1 + joint] - torques[1][1 + joint] == pytest.approx(wanted, rel=2e-3, abs=1), joint + 2
    moment = sum(mass * (start**2 + start * stop + stop**2) / 3 for start, stop, mass in masses)
    assert inertia[0] - inertia[1] == pytest.approx(moment, rel=0.03)


def _share(start: float, stop: float, root: float) -> float:
    """Of a mass that lies evenly from start to stop, what is outboard of root."""
    return float(stop > root) if start == stop else np.clip((stop - root) / (stop - start), 0, 1)


@pytest.mark.parametrize("effect", WAYS)
def test_what_gives_gives_as_far_as_its_stiffness_says(effect: str) -> None:
    direction, way = WAYS[effect]
    axis = "xyz".index(direction)
    plant, healthy = (make_plant(WEIGHTLESS, 2, effects) for effects in ([parse_effect(effect)], []))
    tips = [p.tip(p.static_equilibrium(STRETCHED, FORCE * np.eye(3)[axis])) for p in (plant, healthy)]
    assert (tips[0] - tips[1])[axis] == pytest.approx(way, rel=0.02)


@pytest.mark.parametrize(("link", "axis"), [(2, "v"), (3, "w"), (5, "v")])
@pytest.mark.parametrize("hinges", [1, 4])
def test_the_sun_moves_the_tip_of_a_link(link: int, axis: str, hinges: int) -> None:
    bend = parse_effect(f"thermal_bending:link={link},axis={axis},displacement=0.03")
    plant, healthy = (make_plant(WEIGHTLESS, hinges, effects) for effects in ([bend], []))
    last = len(BOOM.sensors.markers_x) * (link - 1) - 1  # the marker on the link's tip
    moved = [p.markers(p.static_equilibrium(STRETCHED))[last] for p in (plant, healthy)]
    assert abs((moved[0] - moved[1])["xyz".index("y" if axis == "w" else "z")]) == pytest.approx(0.03, rel=0.01)


def test_a_side_wind_turns_the_boom_by_the_drag_of_its_links() -> None:
    wind = parse_effect("wind:mean_speed=10,direction=1.5707963267948966")
    assert isinstance(wind, ForceEffect)
    plant = make_plant(BOOM, 1, [wind])
    motion = Motion(np.zeros(1), {f"joint{k + 1}": STRETCHED[k : k + 1] for k in range(5)}, machine=BOOM)
    loads = {site: force[0] for site, force in wind.force(motion).items()}
    still = np.zeros(plant.model.nq)
    found = (plant.rest_force(still, {}) - plant.rest_force(still, loads))[plant.joints[0]]
    wanted = 0.0
    for root, link in zip(ROOTS, BOOM.links):
        x = np.linspace(0, link.length, 1001)
        height = np.interp(x, [0, link.length], link.height)
        wanted += np.trapezoid(0.5 * 1.225 * 1.3 * 10**2 * height * (root + x), x)
    assert found == pytest.approx(wanted, rel=0.01)


def test_a_flank_gives_little_to_the_weight_that_lies_on_it() -> None:
    """Steel, not oil; a gap is seen by its size, not by how soft its flanks are."""
    for joint in (3, 4, 5):
        loaded, healthy = (
            make_plant(BOOM, 2, effects)
            for effects in ([parse_effect(f"joint_play:joint={joint},half_gap={1e-6}")], [])
        )
        tips = [p.tip(p.static_equilibrium(STRETCHED)) for p in (loaded, healthy)]
        assert (tips[1] - tips[0])[2] == pytest.approx(GIVES * (REACH - ROOTS[joint - 2]), rel=0.05)
