"""Laws of the MJCF model at any number of hinges and with either offset profile."""

from functools import cache
from pathlib import Path

import mujoco
import numpy as np
import pytest

from boom_mj.machine import load_machine
from boom_mj.reference import JOINTS, ReferenceModel
from boom_mj.simulation import Plant, make_plant

Array = np.ndarray
BOOM = load_machine(Path(__file__).parents[2] / "models" / "boom36.toml")
LOW, HIGH = np.array([drive.range for drive in BOOM.drives]).T
TURRET = 1e-3  # kg, the placeholder mass of a body that only slews
every_model = pytest.mark.parametrize(
    ("hinges", "kind"), [(n, kind) for n in (1, 2, 4) for kind in ("ramp", "step")], ids=lambda value: str(value)
)


@cache
def plant(hinges: int, kind: str) -> Plant:
    profile = BOOM.offset_profile.model_copy(update={"kind": kind})
    return make_plant(BOOM.model_copy(update={"offset_profile": profile}), hinges)


def poses(count: int) -> Array:
    return np.random.default_rng(3).uniform(LOW, HIGH, (count, 5))


def at(model: Plant, joints: Array) -> tuple[Array, Array]:
    """MuJoCo's and the reference's coordinates of straight links."""
    qpos, q = np.zeros(model.model.nq), np.zeros(JOINTS + 12)
    qpos[model.joints] = q[:JOINTS] = joints
    return qpos, q


@every_model
def test_bodies_weigh_what_the_machine_weighs(hinges, kind):
    total = sum(link.mass for link in BOOM.links) + sum(m for points in BOOM.masses_on_link for _, m in points)
    assert plant(hinges, kind).model.body_mass.sum() - TURRET == pytest.approx(total, rel=1e-6)  # exact but for weights


@every_model
def test_inertias_are_those_of_bodies(hinges, kind):
    model = plant(hinges, kind).model
    for number in range(1, model.nbody):
        a, b, c = np.sort(model.body_inertia[number])
        name = model.body(number).name
        if name == "base":  # stands still
            continue
        assert model.body_mass[number] > 0, name
        assert a > 0, name
        assert a + b >= c * (1 - 1e-9), name  # rounding: a line of masses has equality but for its rotary inertia


@pytest.mark.parametrize("kind", ["ramp", "step"])
@pytest.mark.parametrize("hinges", [1, 4])
def test_straight_links_have_the_reference_mass_matrix(hinges, kind):
    model = plant(hinges, kind)
    reference = ReferenceModel(model.machine)
    for joints in poses(10):
        qpos, q = at(model, joints)
        found = model.mass_matrix(qpos)[np.ix_(model.joints, model.joints)]
        true = reference.mass_matrix(q)[:JOINTS, :JOINTS]
        scale = np.sqrt(np.diag(true))
        error = np.abs(found - true) / np.outer(scale, scale)
        # the reference has no rotary inertia across the link's axis, short bodies have a little
        assert error.max() < 1e-3, f"{np.degrees(joints).round(1)} deg: {error.max():.2g}"


@every_model
def test_names_that_outside_checks_use_are_there(hinges, kind):
    model = plant(hinges, kind).model
    axes = ("v", "w", "torsion")
    joints = {f"joint{k}" for k in range(1, 6)}
    joints |= {f"link{i}_{axis}_{k + 1}" for i in range(2, 6) for axis in axes for k in range(hinges)}
    assert {model.joint(k).name for k in range(model.njnt)} == joints
    sites = {"tip", *(f"imu_link{i}" for i in range(2, 6)), *(f"marker{k}" for k in range(1, 13))}
    assert sites <= {model.site(k).name for k in range(model.nsite)}
    assert model.nv == 5 + 12 * hinges


@every_model
def test_markers_and_tips_lie_on_the_reference_neutral_axis(hinges, kind):
    model = plant(hinges, kind)
    reference = ReferenceModel(model.machine)
    fractions = np.array(BOOM.sensors.markers_x)
    places = tuple(np.append(fractions, 0.0) * link.length for link in BOOM.links)
    for joints in poses(10):
        qpos, q = at(model, joints)
        model.tip(qpos)  # brings `scratch` to the pose
        sections = reference.sections(q, places)
        for index, section in enumerate(sections):
            first = fractions.size * index + 1
            names = [*(f"marker{first + k}" for k in range(fractions.size)), f"imu_link{index + 2}"]
            found = np.array([model.scratch.site(name).xpos for name in names])
            assert np.abs(found - section.position).max() < 1e-3  # m
        assert np.abs(model.tip(qpos) - sections[-1].position[-1]).max() < 1e-3


@every_model
def test_ritz_coordinates_are_read_back(hinges, kind):
    model = plant(hinges, kind)
    shapes = model.boom.shape_matrix(model.model)
    elastic = np.random.default_rng(5).normal(size=(12, 20)) * np.tile([0.02, 0.2, 0.2], 4)[:, None]
    error = np.abs(model.ritz @ shapes @ elastic - elastic) / np.abs(elastic).max(axis=1, keepdims=True)
    assert error.max() < 1e-9
    assert np.linalg.matrix_rank(shapes) == 12


@every_model
def test_saved_model_is_the_model(hinges, kind):
    model = plant(hinges, kind)
    again = mujoco.MjModel.from_xml_string(model.boom.to_xml())
    for name in ("body_mass", "body_inertia", "jnt_stiffness", "dof_damping"):
        # MuJoCo writes six digits
        assert getattr(again, name) == pytest.approx(getattr(model.model, name), rel=1e-5), name
    assert again.opt.timestep == model.model.opt.timestep
