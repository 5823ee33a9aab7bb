"""A clamped link of equivalent hinges against the Euler-Bernoulli cantilever: frequencies, sag, and where it points."""

from pathlib import Path

import mujoco
import numpy as np
import pytest
from scipy.linalg import eigh

from boom_mj.errors import MachineFileError
from boom_mj.machine import Beam, load_machine, load_model
from boom_mj.mjcf import build_beam

REAL = Path(__file__).parents[2] / "models" / "real"
FILE = REAL / "clamped_beam_machine.toml"
ROOTS = np.array([1.8751040687, 4.6940911330])  # of cos x cosh x = -1


def beam(**changes: object) -> Beam:
    found = load_model(FILE)
    assert isinstance(found, Beam)
    return found.model_copy(update={"link": (found.link[0].model_copy(update=changes),)})


THIN = beam(height=(1e-3, 1e-3), wall=(5e-4, 5e-4), rotary_inertia=(1e-9, 1e-9))  # theory knows no rotary inertia


def bending_stiffness(found: Beam) -> float:
    link = found.links[0]
    return link.youngs_modulus_y * link.width[0] * link.height[0] ** 3 / 12


def matrices(found: Beam, hinges: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Mass and stiffness, (n, n), and the hinges' torques under weight, (n,), all of the straight beam."""
    model = build_beam(found, hinges).compile()
    data, mass = mujoco.MjData(model), np.zeros((model.nv, model.nv))
    mujoco.mj_forward(model, data)
    mujoco.mj_fullM(model, data, mass)
    return mass, np.diag(model.jnt_stiffness.reshape(model.njnt, -1)[:, 0]), -data.qfrc_bias


def frequency_errors(hinges: int) -> np.ndarray:
    link, (mass, stiffness, _) = THIN.links[0], matrices(THIN, hinges)
    theory = ROOTS**2 * np.sqrt(bending_stiffness(THIN) / (link.mass * link.length**3))  # rad/s
    return np.sqrt(eigh(stiffness, mass, eigvals_only=True)[:2]) / theory - 1


@pytest.mark.parametrize("hinges", range(3, 9))
def test_the_first_frequency(hinges: int) -> None:
    assert abs(frequency_errors(hinges)[0]) < 5e-4  # found: three are 0.048 % off, four 0.006 %


def test_frequencies_converge_with_the_fourth_power_of_the_hinges() -> None:
    assert np.log2(frequency_errors(8) / frequency_errors(16)) == pytest.approx(4, abs=0.25)


@pytest.mark.parametrize("hinges", [3, 8])
def test_it_sags_as_it_should(hinges: int) -> None:
    """rho A g L^4 / 8 E I, 6.6 mm."""
    found, (_, stiffness, torque) = beam(), matrices(beam(), hinges)
    link, model = found.links[0], build_beam(beam(), hinges).compile()
    reach = np.array([-model.joint(f"beam/{k + 1}").pos[0] for k in range(hinges)])
    sag = link.mass * found.gravity * link.length**3 / 8 / bending_stiffness(found)
    assert float(reach @ np.linalg.solve(stiffness, torque)) == pytest.approx(-sag, rel=1e-9)


def test_it_points_where_the_file_says() -> None:
    model = build_beam(beam(), 8).compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    root = np.array([0.0593, 0.0337, -0.0245])
    assert data.site("tip").xpos == pytest.approx(root + np.array([0, 0, 0.1]))
    assert data.sensor("tip2").data == pytest.approx(root + np.array([0.0034, 0.0175, 0.1]))  # up is x, right is y
    assert model.opt.gravity == pytest.approx([-9.81, 0, 0])
    assert model.body_mass.sum() == pytest.approx(0.0963)


def test_the_model_of_the_real_beam_is_what_the_generator_writes() -> None:
    spec = build_beam(beam(), 6)
    spec.compile()
    assert spec.to_xml() == (REAL / "clamped_beam.xml").read_text()


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("offset = 0.0", "offset = 0.1", "link.offset = 0.1: a clamped link has none"),
        ("up = [1.0", "up = [0.5", "unit vectors at a right angle"),
        ("wall = [0.015, 0.015]", "wall = [0.016, 0.016]", "at most half the box, 0.015 m"),
        ("gravity = 9.81", "weight = 9.81", "weight = 9.81: unknown key; known here: clamp, damping, gravity"),
    ],
)
def test_bad_files(tmp_path: Path, old: str, new: str, said: str) -> None:
    path = tmp_path / "beam.toml"
    path.write_text(FILE.read_text().replace(old, new))
    with pytest.raises(MachineFileError, match=said.replace("[", r"\[")):
        load_model(path)


def test_a_beam_is_no_boom() -> None:
    with pytest.raises(MachineFileError, match=r"^[^\n]*kind = 'beam': input should be 'boom'$"):
        load_machine(FILE)
