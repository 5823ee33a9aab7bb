"""Laws do what their formulas say: in MuJoCo, in sensors, and written to a file and read again."""

import mujoco
import numpy as np
import pytest

from boom_mj.discovery import where
from boom_mj.discovery.grammar import GRAMMARS
from boom_mj.discovery.places import Place, law_class, value_of
from boom_mj.effects import BOOM_SITES, ModelEffect, Motion, Parameter, Site, laws, make_effect
from boom_mj.effects.spec_edits import bent_by
from boom_mj.machine import Machine, load_machine
from boom_mj.recording import Signal
from boom_mj.simulation import CATALOGUE, Plant, make_plant, run_experiment
from boom_mj.testing import check_effect

pytestmark = pytest.mark.usefixtures("own_files")


def site(**location: int) -> Site:
    return next(s for s in BOOM_SITES if s.location == location)


class Drag(laws.TipLaw):
    """Drag of the tip."""

    id = "test_drag"
    table = {"drag": Parameter("N s^2/m^2", 0.0, 0.0, 1e4, 20.0)}


class Load(laws.TipLaw):
    """A mass at the tip, told by its weight and its inertia."""

    id = "test_load"
    table = {"weight": Parameter("N", 0.0, -1e5, 1e5, 200.0), "inertia": Parameter("kg", 0.0, 0.0, 1e4, 20.0)}


class DragOfMiddle(laws.MiddleLaw):
    """Drag of the middle of a link."""

    id = "test_drag_of_middle"
    table = Drag.table


class LoadOnMiddle(laws.MiddleLaw):
    """A mass on the middle of a link."""

    id = "test_load_on_middle"
    table = Load.table


class Hard(laws.LinkLaw):
    """A link that hardens, is stiffer and rests bent, and its stop."""

    id = "test_hard"
    table = {
        "linear": Parameter("1", 0.0, -0.9, 9.0, 0.3),
        "offset": Parameter("1/m", 0.0, -1.0, 1.0, 1e-3),
        "cube": Parameter("m^2", 0.0, 0.0, 1e9, 1e5),
        "stop_stiffness": Parameter("N m/rad", 0.0, 0.0, 1e9, 1e6),
        "stop": Parameter("rad", 0.01, -1.0, 1.0, 0.01),
    }


class Ground(laws.BaseLaw):
    """A boom aslant on ground that hardens."""

    id = "test_ground"
    table = {
        "roll_tilt": Parameter("rad", 0.0, -0.1, 0.1, 5e-3),
        "roll_give": Parameter("rad/(N m)", 0.0, 0.0, 1e-6, 3e-9),
        "pitch_give": Parameter("rad/(N m)", 0.0, 0.0, 1e-6, 3e-9),
        "pitch_hardness": Parameter("1/rad^2", 0.0, 0.0, 1e8, 3e5),
    }


@pytest.mark.parametrize(("kind", "at", "point"), [(Drag, Site(), "tip"), (DragOfMiddle, site(link=4), "marker8")])
def test_drag_takes_the_power_of_its_formula(kind: type[laws.TipLaw], at: Site, point: str) -> None:
    """The point moves at v, so the fluid takes c v^3: an independent way to what MuJoCo does with an ellipsoid."""
    drag = 80.0
    plain, plant = (make_plant(load_machine("boom36"), 2, effects) for effects in ((), (kind(at, drag=drag),)))
    rng = np.random.default_rng(0)
    qpos, qvel = 0.1 * rng.standard_normal(plant.model.nq), 0.1 * rng.standard_normal(plant.model.nv)
    power = []
    for one in (plain, plant):
        data, jacobian = mujoco.MjData(one.model), np.zeros((3, one.model.nv))
        data.qpos[:], data.qvel[:] = qpos, qvel
        mujoco.mj_forward(one.model, data)
        power.append(float(data.qfrc_passive @ qvel))
        mujoco.mj_jacSite(one.model, data, jacobian, None, one.model.site(point).id)
    speed = float(np.linalg.norm(jacobian @ qvel))
    assert power[1] - power[0] == pytest.approx(-drag * speed**3, rel=1e-4)


class Explicit(ModelEffect):
    """The integrator of a drag without the drag."""

    id = "test_explicit"

    def edit(self, spec: mujoco.MjSpec, machine: Machine) -> None:
        spec.option.integrator = mujoco.mjtIntegrator.mjINT_EULER


def test_springs_and_dampers_do_not_know_which_integrator_drag_needs() -> None:
    machine, brief = load_machine("boom36"), CATALOGUE["release_bow_vertical"].model_copy(update={"duration": 10.0})
    motions = [run_experiment(make_plant(machine, 2, effects), brief) for effects in ((), (Explicit(),))]
    np.testing.assert_array_equal(*(motion.qpos for motion in motions))


def test_weight_and_inertia_are_a_payload() -> None:
    """What the tip weighs is a force that acts from outside; its inertia is the model's."""
    machine, mass = load_machine("boom36"), 50.0
    payload = make_plant(machine, 2, (make_effect("tip_payload", {"mass": mass}),))
    law = make_plant(machine, 2, (Load(Site(), inertia=mass),))
    rng = np.random.default_rng(0)
    qpos, qvel = 0.1 * rng.standard_normal(law.model.nq), 0.1 * rng.standard_normal(law.model.nv)
    acts = []
    for one, weight in ((payload, 0.0), (law, mass * np.linalg.norm(law.model.opt.gravity))):
        data = mujoco.MjData(one.model)
        data.qpos[:], data.qvel[:] = qpos, qvel
        mujoco.mj_forward(one.model, data)
        site = data.site("tip")
        mujoco.mj_applyFT(one.model, data, [0, 0, -weight], np.zeros(3), site.xpos, site_body(one), data.qfrc_applied)
        mujoco.mj_forward(one.model, data)
        acts.append(data.qacc.copy())
    np.testing.assert_allclose(*acts, rtol=1e-6)


def site_body(plant: Plant) -> int:
    return int(plant.model.site("tip").bodyid[0])


def test_a_weight_on_a_middle_marker_turns_its_joint_by_the_lever() -> None:
    plant = make_plant(load_machine("boom36"), 2)
    data, motion, torque = mujoco.MjData(plant.model), Motion(np.zeros(1), machine=plant.machine), []
    mujoco.mj_forward(plant.model, data)
    for law in (Load(Site(), weight=500.0), LoadOnMiddle(site(link=5), weight=500.0)):
        ((name, force),) = law.force(motion).items()
        at, turned = plant.model.site(name), np.zeros(plant.model.nv)
        mujoco.mj_applyFT(plant.model, data, force[0], np.zeros(3), data.site(name).xpos, int(at.bodyid[0]), turned)
        torque.append(turned[plant.model.joint("joint5").dofadr[0]])
    lever = 1 + plant.machine.sensors.markers_x[1]
    assert torque[0] and torque[1] == pytest.approx(lever * torque[0], rel=1e-6)


def test_link_law_bends_as_its_formula() -> None:
    machine, link = load_machine("boom36"), 3
    cube, linear, offset, bend = 4e4, 0.2, 1e-4, 2e-3
    plain = make_plant(machine, 3)
    plant = make_plant(machine, 3, (Hard(site(link=link), cube=cube, linear=linear, offset=offset),))
    own = [k for k in range(plant.model.njnt) if plant.model.joint(k).name.startswith(f"link{link}_v_")]
    lengths = [float(length) for _, length in bent_by(plain.boom.spec, machine, link, "v")]
    for joint, length in zip(own, lengths):
        torque = []
        for one in (plain, plant):
            data = mujoco.MjData(one.model)
            data.qpos[one.model.jnt_qposadr[joint]] = bend
            mujoco.mj_forward(one.model, data)
            torque.append(float(data.qfrc_spring[one.model.jnt_dofadr[joint]]))
        curvature = (bend - offset * length) / length  # a hinge bends about where it rests
        expected = (1 + linear + cube * curvature**2) * curvature * length / bend
        assert torque[1] / torque[0] == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize(
    ("middle", "width", "written"), [(2048.37, 8.0, 2048.4), (0.02543, 0.6, 0.03), (-1.7634, 2.0, -1.8)]
)
def test_the_middle_of_a_variable_is_as_exact_as_its_range_asks(middle: float, width: float, written: float) -> None:
    """An encoder far from its zero: three digits of 2048 would lie beside where it is."""
    assert where._middle(middle + width * np.linspace(-0.5, 0.5, 101)) == written


def test_a_ripples_period_does_not_move_with_its_phase() -> None:
    """Else fits end beside it: a cylinder's ripple of 0.308 m came out as 0.323 m, 1.4 instead of 1.0 left."""
    position = np.linspace(3.0, 4.0, 1000)
    words = {"x": "m", "F": "N", "creep": 1e-3, "middle": 3.5}
    place = Place(laws.CylinderLaw, site(cylinder=2), "a cylinder", {"position": position}, 1.0, words)
    ripple = next(term for term in place.terms if term.name == "ripple")

    def at(period: float) -> np.ndarray:
        return np.stack(
            [value_of(place.text(part.function), {"position": position, "period": period}) for part in ripple.parts]
        )

    phases, moved = at(0.3).T, (at(0.301) - at(0.3))[0]
    left = moved - phases @ np.linalg.lstsq(phases, moved)[0]
    assert left @ left > 0.9 * moved @ moved


@pytest.mark.parametrize("kind", [Drag, DragOfMiddle, Ground, Hard, Load, LoadOnMiddle])
def test_laws_of_effects_hold(kind: type) -> None:
    check_effect(kind, machine=load_machine("boom36"))


class Slope(laws.MarkerLaw):
    """A tracker whose scale is wrong upwards."""

    id = "test_slope"
    axis = "z"
    table = {"scale": Parameter("1", 0.0, -1.0, 1.0, 0.01)}

    def law(self, reading: np.ndarray, angle: np.ndarray, time: np.ndarray, scale: float) -> np.ndarray:
        return scale * reading


def test_a_marker_law_alters_one_coordinate_of_one_marker() -> None:
    check_effect(Slope)
    time = np.arange(5.0)
    points = np.arange(5 * 36.0).reshape(5, 36)
    signals = {
        "joint/position": Signal(time, np.zeros((5, 5)), tuple("12345"), "rad", ""),
        "markers": Signal(time, points, tuple(map(str, range(36))), "m", ""),
    }
    added = Slope(site(marker=4), scale=0.1).observe(signals, load_machine("boom36"))["markers"].values - points
    assert np.flatnonzero(added.any(axis=0)).tolist() == [11]
    np.testing.assert_allclose(added[:, 11], 0.1 * points[:, 11])


class Warming(laws.JointLaw):
    """Grease that thins as it warms."""

    id = "test_warming"
    variables = laws.JointLaw.variables | laws.TEMPERATURE
    table = {"thinning": Parameter("N s/(m K)", 0.0, -1.0, 1.0, 0.01)}

    def law(self, speed: np.ndarray, temperature: np.ndarray, thinning: float, **others: np.ndarray) -> np.ndarray:
        return thinning * speed * (temperature - 30)


def test_a_law_of_temperature_is_only_where_one_is_logged() -> None:
    cold, warm = (Site((("joint", name),), frozenset({"mjcf", "measured", *tags})) for name, tags in WARM.items())
    assert Warming.allowed([cold, warm]) == (warm,)
    time = np.arange(3.0)
    motion = Motion(time, {"b": time}, {"b": 2 + time}, {"b": time}, {"b": 30 + time})
    np.testing.assert_allclose(Warming(warm, thinning=0.5).force(motion)["b"], -0.5 * (2 + time) * time)


WARM = {"a": (), "b": ("temperature",)}


@pytest.mark.parametrize("name", [name for name in GRAMMARS if hasattr(getattr(laws, name), "law")])
def test_every_term_is_a_law_that_vanishes(name: str) -> None:
    """What a term adds is its formula times its coefficients, and nothing where these are 0."""
    base, rng = getattr(laws, name), np.random.default_rng(1)
    time = np.arange(200) * 0.1
    known = [*base.variables, "temperature"]
    variables = {word: time if word == "time" else rng.uniform(0.5, 1.5, 200) for word in known}
    words = {"x": "m", "F": "N", "creep": 1e-3, "middle": 1.0, "warm": 1.0}
    place = Place(base, Site((("cylinder", 2),)), "a place", variables, 100.0, words)
    for term in GRAMMARS[name]:
        kind = law_class(place, (term,))
        assert kind(place.site).silent
        for group in kind.screening(place.site):
            for point in group:
                law = kind(place.site, **point)
                added = law.law(**variables, **law.values)
                assert added.shape == time.shape and np.isfinite(added).all()
        coefficient = term.parts[0].coefficient
        once, twice = (kind(place.site, **{coefficient: n * kind.table[coefficient].typical}) for n in (1.0, 2.0))
        values = [one.law(**variables, **one.values) for one in (once, twice)]
        assert np.allclose(2 * values[0], values[1])


def test_what_fades_begins_whole_at_each_stop_and_knows_its_direction():
    time = np.arange(0.0, 6.0, 0.01)
    speed = np.select([(time >= 1) & (time < 2), (time >= 4) & (time < 5)], [1.0, -1.0], 0.0)
    said = laws.fading(time, laws.direction(speed, 1e-3), 0.5)
    assert not said[time < 2 - 0.005].any()
    assert not said[(time >= 4) & (time < 5 - 0.005)].any()
    rest = (time >= 2) & (time < 4 - 0.005)
    np.testing.assert_allclose(said[rest], np.exp(-(time[rest] - 1.99) / 0.5))
    np.testing.assert_allclose(said[time > 5 + 0.005], -np.exp(-(time[time > 5 + 0.005] - 4.99) / 0.5))


AXES = Site((("axes", "roll+pitch"),))


def test_a_base_that_gives_is_the_librarys_where_it_does_not_harden() -> None:
    machine = load_machine("boom36")
    law = Ground(AXES, roll_tilt=0.01, roll_give=1 / 4e8, pitch_give=1 / 2e8)
    tilt = make_effect("base_tilt", {"roll": 0.01})
    springs = make_effect("base_compliance", {"axes": "roll+pitch", "roll": 4e8, "pitch": 2e8})
    saved = []
    for effects in ((law,), (tilt, springs)):
        model = make_plant(machine, 2, effects).model
        saved.append(np.zeros(mujoco.mj_sizeModel(model), np.uint8))
        mujoco.mj_saveModel(model, None, saved[-1])
    assert np.array_equal(*saved)


def test_a_base_that_hardens_turns_as_its_formula_says() -> None:
    give, hardness = 5e-9, 4e5
    plant = make_plant(load_machine("boom36"), 2, (Ground(AXES, pitch_give=give, pitch_hardness=hardness),))
    data = mujoco.MjData(plant.model)
    joint = plant.model.joint("base_pitch")
    angle = data.qpos[joint.qposadr[0]] = 3e-3
    mujoco.mj_forward(plant.model, data)
    moment = -data.qfrc_spring[joint.dofadr[0]]
    assert angle * (1 + hardness * angle**2) == pytest.approx(give * moment)


def test_tilts_and_springs_of_a_base_add_up() -> None:
    """A law beside the library's effects: order is no matter, and none undoes another."""
    law = Ground(AXES, roll_tilt=0.01, pitch_give=1 / 2e8, pitch_hardness=4e5)
    others = make_effect("base_tilt", {"roll": 0.02}), make_effect("base_compliance", {"axes": "pitch", "pitch": 6e8})
    for effects in ((law, *others), (*others, law)):
        model = make_plant(load_machine("boom36"), 2, effects).model
        assert model.joint("base_pitch").stiffness[0] == pytest.approx(1.5e8)
        assert model.joint("base_pitch").stiffnesspoly[-1] == pytest.approx(4e5 * 1.5e8)
        assert np.arctan2(-model.opt.gravity[1], -model.opt.gravity[2]) == pytest.approx(0.03)
