"""Mass (34) and centre of gravity (35) of a link make a line mass that has them."""

from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import quad

from boom_mj.calibration.parameters import Parameter
from boom_mj.machine import load_machine, sections

BOOM = load_machine(Path(__file__).parents[2] / "models" / "boom36.toml")


@pytest.mark.parametrize("number", [2, 3, 4, 5])
@pytest.mark.parametrize("factor", [0.9, 1.0, 1.1])
def test_a_scaled_mass_is_the_integral_of_its_line_mass(number: int, factor: float) -> None:
    """(34): the mass that a calibration sets; (35): the centre of gravity stays where the file has it."""
    link = Parameter("mass", number).scaled(BOOM, factor).links[number - 2]
    mass = quad(lambda x: float(sections.line_mass(link, x)), -link.length, 0)[0]
    moment = quad(lambda x: x * float(sections.line_mass(link, x)), -link.length, 0)[0]
    assert mass == pytest.approx(factor * BOOM.links[number - 2].mass, rel=1e-12)
    assert moment / mass == pytest.approx(BOOM.links[number - 2].center_of_gravity, rel=1e-12)


@pytest.mark.parametrize("number", [2, 3, 4, 5])
def test_a_moved_centre_of_gravity_leaves_the_mass(number: int) -> None:
    parameter = Parameter("center_of_gravity", number)
    low, high = parameter.bounds(BOOM)
    for factor in np.linspace(low, high, 5):
        link = parameter.scaled(BOOM, factor).links[number - 2]
        mass = quad(lambda x, link=link: float(sections.line_mass(link, x)), -link.length, 0)[0]
        moment = quad(lambda x, link=link: x * float(sections.line_mass(link, x)), -link.length, 0)[0]
        assert mass == pytest.approx(BOOM.links[number - 2].mass, rel=1e-12)
        assert moment / mass == pytest.approx(factor * BOOM.links[number - 2].center_of_gravity, rel=1e-9)
        type(link).model_validate(link.model_dump())  # within the bounds every link is one
