"""The reference model against calculus and hand statics: what must hold whatever the machine's numbers are."""

from pathlib import Path

import numpy as np
import pytest

from boom_mj.machine import AXES, Machine, load_machine, ritz_shapes, sections, statics
from boom_mj.machine.linkages import cylinder2_length, cylinder3_length, moment_arm
from boom_mj.machine.shapes import static_curves
from boom_mj.reference import JOINTS, ReferenceModel, Simplifications, integrate

Array = np.ndarray
BOOM = load_machine(Path(__file__).parents[2] / "models" / "boom36.toml")
STRETCHED = np.zeros(5)
FULL = Simplifications(undeformed_mass=False, no_coriolis=False)
FINITE = Simplifications(undeformed_mass=False, no_coriolis=False, linear_kinematics=False)
POSES = range(3)


def with_profile(machine: Machine, kind: str) -> Machine:
    return machine.model_copy(update={"offset_profile": machine.offset_profile.model_copy(update={"kind": kind})})


def state(seed: int) -> tuple[Array, Array]:
    """Random coordinates and velocities (17,) each: any pose, deflections of some per cent, speeds alike."""
    rng = np.random.default_rng(seed)
    low, high = np.array([drive.range for drive in BOOM.drives]).T
    size = np.array([0.02, 0.3, 0.3] * 4)  # rad, m, m
    q = np.concatenate([rng.uniform(low, high), size * rng.uniform(-1, 1, 12)])
    return q, np.concatenate([0.05 * rng.normal(size=5), size * rng.normal(size=12)])


def slope(function, q: Array, step: float = 1e-5) -> Array:
    """Central differences, (17, ...): error step^2 times third derivatives of order 1, and rounding 1e-16 / step."""
    return np.array([(function(q + d) - function(q - d)) / (2 * step) for d in step * np.eye(q.size)])


def potential(model: ReferenceModel, q: Array) -> float:
    """Weight and strain energy, J, from positions alone."""
    places, masses, _ = model._masses
    height = sum(mass @ section.position[:, 2] for section, mass in zip(model.sections(q, places), masses))
    return float(model.machine.gravity * height + model.stiffness @ q**2 / 2)


@pytest.mark.parametrize("seed", POSES)
@pytest.mark.parametrize("kind", ["ramp", "step"])
def test_jacobian_of_the_tip_is_the_slope_of_its_position(kind, seed):
    model, (q, _) = ReferenceModel(with_profile(BOOM, kind)), state(seed)
    found, true = model.tip(q)[1], slope(lambda q: model.tip(q)[0], q)
    assert np.allclose(found, true, rtol=0, atol=1e-8)  # of 32 m: differences' own error, about 1e-9
    step = np.imag(np.array([model.tip(q + 1e-30j * d)[0] for d in np.eye(q.size)])) / 1e-30
    assert np.allclose(found, step, rtol=0, atol=1e-12)  # rounding


@pytest.mark.parametrize("seed", POSES)
@pytest.mark.parametrize("kind", ["ramp", "step"])
def test_jacobians_along_the_links_are_slopes_of_positions(kind, seed):
    model, (q, _) = ReferenceModel(with_profile(BOOM, kind)), state(seed)
    places = model._masses[0]
    for number in range(len(places)):
        true = slope(lambda q, k=number: model.sections(q, places)[k].position, q)  # (17, p, 3)
        assert np.allclose(model.sections(q, places)[number].jacobian, np.moveaxis(true, 0, 1), rtol=0, atol=1e-8)


@pytest.mark.parametrize("simple", [Simplifications(), FULL])
@pytest.mark.parametrize("seed", POSES)
def test_mass_matrix_is_symmetric_and_positive(simple, seed):
    mass = ReferenceModel(BOOM, simple).mass_matrix(state(seed)[0])
    assert np.allclose(mass, mass.T, rtol=0, atol=1e-12 * abs(mass).max())  # rounding
    scale = np.sqrt(np.diag(mass))
    assert np.linalg.eigvalsh(mass / np.outer(scale, scale)).min() > 1e-6  # far above rounding of a singular one


@pytest.mark.parametrize("simple", [Simplifications(), FULL, FINITE])
@pytest.mark.parametrize("seed", POSES)
def test_slewing_changes_no_mass_matrix(simple, seed):
    model, (q, _) = ReferenceModel(BOOM, simple), state(seed)
    mass, turned = model.mass_matrix(q), model.mass_matrix(q + 1.234 * np.eye(q.size)[0])
    assert np.allclose(mass, turned, rtol=0, atol=1e-12 * abs(mass).max())  # rounding
    assert not np.allclose(mass, model.mass_matrix(q + 0.5 * np.eye(q.size)[2]), rtol=1e-3)  # joint 3 does


@pytest.mark.parametrize("seed", POSES)
def test_gravity_force_is_the_gradient_of_the_potential(seed):
    model, (q, _) = ReferenceModel(BOOM), state(seed)
    true = slope(lambda q: potential(model, q), q)
    assert np.allclose(model.potential_force(q), true, rtol=0, atol=1e-8 * abs(true).max())  # differences' own error
    weight = model.gravity_force(q)
    assert np.allclose(weight, true - model.stiffness * q, rtol=0, atol=1e-8 * abs(true).max())
    assert abs(weight[0]) < 1e-8 * abs(weight).max()  # slewing lifts nothing


@pytest.mark.parametrize("seed", POSES)
def test_coriolis_forces_do_the_power_of_a_changing_mass_matrix(seed):
    """d/dt (qd D qd / 2) = qd D qdd + qd tau_C, so that qd tau_C = qd Ddot qd / 2."""
    model, (q, velocity) = ReferenceModel(BOOM, FULL), state(seed)
    h = 1e-4  # s: the difference's error is h^2
    rate = (model.mass_matrix(q + h * velocity) - model.mass_matrix(q - h * velocity)) / (2 * h)
    power = velocity @ rate @ velocity / 2
    scale = np.abs(velocity) @ np.abs(rate) @ np.abs(velocity)
    assert velocity @ model.coriolis_force(q, velocity) == pytest.approx(power, abs=1e-6 * scale)
    assert abs(power) > 1e-3 * scale  # there is something to compare


@pytest.mark.parametrize("seed", POSES)
def test_coriolis_forces_follow_from_the_lagrangian(seed):
    """(27) written out with differences of D, every coordinate by itself."""
    model, (q, velocity) = ReferenceModel(BOOM, FULL), state(seed)
    slopes = slope(model.mass_matrix, q)  # (17, 17, 17)
    true = np.einsum("kij,k,j->i", slopes, velocity, velocity)
    true -= np.einsum("kij,i,j->k", slopes, velocity, velocity) / 2
    assert np.allclose(model.coriolis_force(q, velocity), true, rtol=0, atol=1e-7 * abs(true).max())  # differences
    assert not ReferenceModel(BOOM).coriolis_force(q, velocity).any()  # the paper's simplification


def test_energy_stays_after_a_release_without_damping():
    still = BOOM.damping.model_copy(update={"relaxation_time": 0.0, "bending": 0.0, "torsion": 0.0})
    # rotary inertia that brings torsion down to the other frequencies: a non-stiff problem, for the integrator's sake
    heavy = [link.model_copy(update={"rotary_inertia": (3e3, 3e3)}) for link in BOOM.links]
    model = ReferenceModel(BOOM.model_copy(update={"damping": still, "link": tuple(heavy)}))
    held, load = (STRETCHED, np.zeros(5), np.zeros(5)), np.array([0.0, 0.0, -981.0])

    motion = integrate(model, lambda t: held, lambda t: load * (t <= 0), np.linspace(0, 1, 6), 1e-6)
    assert np.allclose(motion.q[0], model.static_equilibrium(STRETCHED, load))
    energy = np.array(
        [v @ model.mass_matrix(q) @ v / 2 + potential(model, q) for q, v in zip(motion.q, motion.velocity)]
    )
    released = energy[0] - potential(model, model.static_equilibrium(STRETCHED))
    print(f"released {released:.1f} J, drift {np.abs(energy - energy[0]).max() / released:.2g}")
    assert released > 50  # J: what the rope stored
    assert np.abs(energy - energy[0]).max() < 1e-4 * released  # of the integrator; 5e-6 over 5 s, too long for here


def test_torque_of_joint_2_carries_the_deformed_boom():
    model = ReferenceModel(BOOM)
    q = model.static_equilibrium(STRETCHED)
    places, masses, _ = model._masses
    moment = sum(mass @ s.position[:, 0] for s, mass in zip(model.sections(q, places), masses)) * BOOM.gravity
    torque = model.joint_torques(q, np.zeros(17), np.zeros(17), np.zeros(3))
    assert torque[1] == pytest.approx(moment, rel=5e-3)  # small rotations lengthen the sagging boom a little
    straight = BOOM.gravity * sum(
        mass * (reach + x)
        for reach, link, points in zip(np.cumsum([link.length for link in BOOM.links]), BOOM.links, BOOM.masses_on_link)
        for x, mass in ((link.center_of_gravity, link.mass), *points)
    )
    assert torque[1] == pytest.approx(straight, rel=5e-3)  # by the machine file alone


@pytest.mark.parametrize("length", [cylinder2_length, cylinder3_length])
def test_moment_arms_are_slopes_of_cylinder_lengths(length):
    drive = BOOM.drives[1 if length is cylinder2_length else 2]
    angles, h = np.linspace(*drive.range, 41)[1:-1], 1e-5
    true = (length(BOOM, angles + h) - length(BOOM, angles - h)) / (2 * h)
    assert np.allclose(moment_arm(length, BOOM, angles), true, rtol=0, atol=1e-8)  # of 1 m: differences' own error
    assert np.all(true * true[0] > 0)  # no dead centre within the joint's range


@pytest.mark.parametrize("link", BOOM.links, ids=lambda link: link.name)
def test_line_mass_gives_back_mass_and_centre_of_gravity(link):
    x, weight = sections.gauss_points(link)
    mass = weight * sections.line_mass(link, x)
    assert mass.sum() == pytest.approx(link.mass, rel=1e-12)  # (34), exact for polynomials
    assert mass @ x / link.mass == pytest.approx(link.center_of_gravity, rel=1e-12)  # (35)
    assert sections.line_mass(link, np.array([-link.length, 0.0])).min() > 0


@pytest.mark.parametrize("index", range(4))
@pytest.mark.parametrize("axis", AXES)
def test_shapes_meet_their_boundary_values_and_the_static_solution(index, axis):
    link, shape = BOOM.links[index], ritz_shapes(BOOM)[index][axis]
    root, pinned = -link.length, axis == "v" and link.support is not None
    assert shape(0.0) == pytest.approx(1, abs=1e-12)
    assert shape(root) == pytest.approx(0, abs=1e-12)
    if pinned:
        assert shape(link.support) == pytest.approx(0, abs=1e-12)
    elif axis != "torsion":
        assert shape.slope(root) == pytest.approx(0, abs=1e-12)
    # two coefficients follow a smooth curve of the same boundary values
    x = np.linspace(root, 0, 301)
    difference = np.abs(shape(x) - static_curves(BOOM, index)[axis].value(x)).max()
    assert difference < 0.05
    assert shape.fit_error == pytest.approx(difference, abs=1e-3)


def uniform(index: int) -> Machine:
    """boom36 with one link a uniform box."""
    link = BOOM.links[index]
    box = {name: (getattr(link, name)[0],) * 2 for name in ("height", "width", "wall", "rotary_inertia")}
    links = list(BOOM.links)
    links[index] = link.model_copy(update={**box, "center_of_gravity": -link.length / 2})
    return BOOM.model_copy(update={"link": tuple(links)})


def test_uniform_cantilever_bends_as_in_the_book():
    link = uniform(3).links[3]
    force, moment, l = 1000.0, 700.0, link.length
    load, ei = 9.81 * link.mass / l, float(sections.bending_stiffness_v(link, 0.0))
    curve = statics.bending(link, sections.bending_stiffness_v, statics.TipLoad(force, moment), 9.81, None)
    x = np.linspace(-l, 0, 33)
    s = x + l
    true = force * s**2 * (3 * l - s) / 6 + moment * s**2 / 2 + load * s**2 * (6 * l**2 - 4 * l * s + s**2) / 24
    strain = force * (l - s) + moment + load * (l - s) ** 2 / 2
    size = abs(curve.value(np.zeros(1))[0])
    assert np.allclose(-curve.value(x), true / ei, rtol=0, atol=1e-6 * size)  # the solver's tolerance
    assert np.allclose(-curve.strain(x), strain / ei, rtol=0, atol=1e-6 * strain.max() / ei)
    assert np.allclose(curve.slope(x), np.gradient(curve.value(x), x, edge_order=2), atol=2e-2 * size / l)  # coarse


def test_uniform_shaft_twists_linearly():
    link = uniform(3).links[3]
    x = np.linspace(-link.length, 0, 9)
    true = (x + link.length) / float(sections.torsional_stiffness(link, 0.0))
    assert np.allclose(statics.torsion(link).value(x), true, rtol=1e-6)  # the solver's tolerance


def test_supported_link_bends_as_in_the_book():
    """An overhanging uniform beam: its support turns by (M over the span / 3 - w span^3 / 24) / EI."""
    link = uniform(0).links[0]
    force, l, span = 1000.0, link.length, link.length + link.support
    over = l - span
    load, ei = 9.81 * link.mass / l, float(sections.bending_stiffness_v(link, 0.0))
    curve = statics.bending(link, sections.bending_stiffness_v, statics.TipLoad(force, 0.0), 9.81, link.support)
    turn = (force * over + load * over**2 / 2) * span / 3 - load * span**3 / 24
    true = (turn * over + force * over**3 / 3 + load * over**4 / 8) / ei
    assert -curve.value(np.zeros(1))[0] == pytest.approx(true, rel=1e-6)  # the solver's tolerance
    assert -curve.slope(np.array([link.support]))[0] == pytest.approx(turn / ei, rel=1e-6)


def test_supported_link_2_is_pinned_at_its_root_and_rests_on_the_cylinder():
    link = BOOM.links[0]
    weight = statics.outboard_load(BOOM, 0, BOOM.gravity)
    curve = statics.bending(link, sections.bending_stiffness_v, weight, BOOM.gravity, link.support)
    root, pin, h = np.array([-link.length]), np.array([link.support]), 1e-6
    tip, most = abs(curve.value(np.zeros(1))[0]), abs(curve.strain(pin)[0])
    assert abs(curve.value(root)[0]) < 1e-9 * tip  # boundary values: the solver's rounding
    assert abs(curve.value(pin)[0]) < 1e-9 * tip
    assert abs(curve.strain(root)[0]) < 1e-9 * most
    for values in (curve.slope, curve.strain):  # continuous over the pin (17)
        assert values(pin - h) == pytest.approx(values(pin + h), rel=1e-5)  # slope times h
    shape = ritz_shapes(BOOM)[0]["v"]
    assert abs(shape(link.support)) < 1e-12
    assert abs(shape(-link.length)) < 1e-12
    assert JOINTS == 5
