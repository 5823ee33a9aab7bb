"""What both models can have changes both alike: MuJoCo gets it as an effect, the reference as another machine."""

from pathlib import Path

import numpy as np
import pytest

from boom_mj.effects import make_effect
from boom_mj.machine import Machine, load_machine
from boom_mj.reference import ReferenceModel, Simplifications
from boom_mj.simulation import make_plant

BOOM = load_machine(Path(__file__).parents[2] / "models" / "boom36.toml")
BENT = np.array([0.0, 0.9, -0.5, -0.4, -0.3])  # rad
MODULI = {"v": "youngs_modulus_y", "w": "youngs_modulus_z", "torsion": "shear_modulus"}
MODES = 3
APART = (
    0.004  # of a frequency's change over its value: both models are within 1 % of each other, and differ as much here
)


def with_link(link: int, **factors: float) -> Machine:
    """The machine with some numbers of a link times factors."""
    links = list(BOOM.links)
    old = links[link - 2]
    changed = {name: scaled(getattr(old, name), factor) for name, factor in factors.items()}
    links[link - 2] = old.model_copy(update=changed)
    return BOOM.model_copy(update={"link": tuple(links)})


def scaled(value: float | tuple[float, float], factor: float) -> float | tuple[float, ...]:
    return tuple(factor * v for v in value) if isinstance(value, tuple) else factor * value


def reference_modes(machine: Machine) -> np.ndarray:
    model = ReferenceModel(machine, Simplifications(linear_kinematics=False))
    return model.modes(model.static_equilibrium(BENT)).frequency[:MODES]


def plant_modes(*effects: tuple[str, dict]) -> np.ndarray:
    plant = make_plant(BOOM, 1, [make_effect(name, values) for name, values in effects])
    return plant.modes(plant.static_equilibrium(BENT)).frequency[:MODES]


@pytest.mark.parametrize("link", [2, 3, 5])
@pytest.mark.parametrize("axis", MODULI)
def test_a_softer_link(link: int, axis: str) -> None:
    wanted = reference_modes(with_link(link, **{MODULI[axis]: 0.8})) / reference_modes(BOOM)
    found = plant_modes(("link_stiffness", {"link": link, "axis": axis, "factor": 0.8})) / plant_modes()
    np.testing.assert_allclose(found, wanted, atol=APART)


@pytest.mark.parametrize("link", [2, 3, 4, 5])
def test_a_heavier_link(link: int) -> None:
    wanted = reference_modes(with_link(link, mass=1.2, rotary_inertia=1.2)) / reference_modes(BOOM)
    found = plant_modes(("link_mass", {"link": link, "factor": 1.2})) / plant_modes()
    np.testing.assert_allclose(found, wanted, atol=APART)


@pytest.mark.parametrize(("link", "stretch", "hinges"), [(3, 1.03, (1, 4)), (5, 1.03, (1, 4)), (4, 0.97, (2, 4))])
def test_a_link_longer_or_shorter(link: int, stretch: float, hinges: tuple[int, ...]) -> None:
    """The one hinge of the paper is tuned to its machine, which link 4 shows more than others."""
    other = with_link(link, length=stretch, center_of_gravity=stretch, rotary_inertia=1 / stretch)
    error = (stretch - 1) * BOOM.links[link - 2].length
    effect = "link_length", {"link": link, "error": error}
    np.testing.assert_allclose(
        plant_modes(effect) / plant_modes(), reference_modes(other) / reference_modes(BOOM), atol=APART
    )
    for count in hinges:
        drawn, stretched = make_plant(other, count), make_plant(BOOM, count, [make_effect(*effect)])
        tips = [plant.tip(plant.static_equilibrium(BENT)) for plant in (drawn, stretched)]
        np.testing.assert_allclose(*tips, atol=2e-3 * abs(error))


def test_a_longer_link_leaves_the_spring_of_its_drive_as_it_is() -> None:
    effects = [
        make_effect("link_length", {"link": 3, "error": 0.5}),
        make_effect("hydraulic_compliance", {"joint": 3, "stiffness": 2e7}),
    ]
    stiffness = [make_plant(BOOM, 2, both).model.jnt_stiffness for both in (effects, effects[::-1])]
    np.testing.assert_array_equal(*stiffness)
    assert 2e7 in stiffness[0]


def test_a_longer_link_is_drawn_as_long() -> None:
    effect = make_effect("link_length", {"link": 4, "error": 0.05 * BOOM.links[2].length})
    longer = with_link(4, length=1.05, center_of_gravity=1.05)
    extents = [plant.model.geom_aabb for plant in (make_plant(longer, 3), make_plant(BOOM, 3, [effect]))]
    np.testing.assert_allclose(*extents, atol=1e-3)
