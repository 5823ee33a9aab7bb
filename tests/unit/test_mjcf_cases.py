"""Cases of machines with a channel map: plants that are not the diagnosing model, what is drawn, how it is sealed."""

import json
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path

import mujoco
import numpy as np
import pytest

from boom_mj.blind import MjcfBench, make_cases, read_answer, score
from boom_mj.blind.mjcf_bench import _healthy
from boom_mj.blind.mjcf_plant import MjcfPlant
from boom_mj.blind.plant_file import LEAD, parse_plant
from boom_mj.blind.run import read_case, solve
from boom_mj.blind.sampling import CLUTTER, Order, draw_clutter, family, known_effects
from boom_mj.diagnosis.linearisation import linearise
from boom_mj.effects import Effect, make_effect
from boom_mj.errors import InputError
from boom_mj.estimation.bootstrap import gap
from boom_mj.systems.mjcf.channel_map import parse_channel_map

BENCHES = Path(__file__).parents[2] / "models" / "benches"
KINDS = sorted(path.name.removesuffix(".plant.toml") for path in BENCHES.glob("*.plant.toml"))
PLANT = """
rate = 200
step = 0.4
effects = ["series_compliance:joint=slide,stiffness=3e7"]
servo.slide = {kp = 4e5, kv = 8e3}
sensor.force = {noise = 1.0}
[[motion]]
name = "stroke"
part = "train"
duration = 10.5
reference.carriage = {knots = [[1.0, 0.0], [2.5, 0.3], [3.0, 0.3], [5.0, -0.2], [6.0, -0.2], [8.0, 0.2]]}
[[motion]]
name = "swing"
part = "holdout"
duration = 10.5
reference.carriage = {sines = [[0.15, 0.3, 0.5], [0.02, 1.3, 0.0]]}
"""


@cache
def drive() -> MjcfBench:
    """A linear drive with short motions."""
    return replace(MjcfBench.beside(BENCHES / "linear_drive.toml"), plant=PLANT)


def on_the_bench(*effects: Effect, plant: str = PLANT, motion: int = 0) -> dict[str, np.ndarray]:
    """A log of the linear drive without chance."""
    channels = parse_channel_map(drive().channels)
    told = parse_plant(plant, "plant", channels)
    machine = MjcfPlant(mujoco.MjSpec.from_string(drive().model), channels, told, effects)
    return machine.record(told.motion[motion], np.random.default_rng(0))


def effect(name: str, **entries: float | str) -> Effect:
    return make_effect(name, entries, drive().sites)


def test_there_are_eight_kinds() -> None:
    assert len(KINDS) >= 8


@pytest.mark.parametrize("name", KINDS)
def test_every_bench_records_its_machine(name: str) -> None:
    """At rest before a log begins, and nothing but what each motion asks for."""
    bench = MjcfBench.beside(BENCHES / f"{name}.toml")
    channels = parse_channel_map(bench.channels)
    plant = parse_plant(bench.plant, name, channels)
    motion = plant.motion[0].model_copy(update={"duration": 2.0})
    own = mujoco.MjSpec.from_string(bench.model)
    machine = MjcfPlant(own, channels, plant, ())
    log = machine.record(motion, np.random.default_rng(0))
    assert {entry.field for entry in channels.channel} | {channels.time} == set(log)
    assert all(len(column) == 2 * plant.rate + 1 and np.isfinite(column).all() for column in log.values())
    assert machine.model.opt.timestep < 0.5 * own.option.timestep
    assert machine.model.opt.integrator != own.option.integrator


def test_a_servo_follows_and_does_not_impose() -> None:
    log = on_the_bench()
    asked = np.interp(log["t"], [0, 1], [0, 0])
    moved = log["x"] - asked
    assert moved[np.searchsorted(log["t"], 2.8)] == pytest.approx(0.3, abs=2e-3)
    assert np.abs(np.diff(log["x"])).max() > 0 and abs(log["x"][0]) < 1e-9
    mass, damping = 60.0, 80.0
    speed = np.gradient(log["x"], log["t"])
    force = mass * np.gradient(speed, log["t"]) + damping * speed
    assert log["f"][20:-20] == pytest.approx(force[20:-20], abs=6.0)  # noise of 1 N


def test_what_an_actuator_does_is_not_what_its_log_says() -> None:
    """Of the same motion a motor of 1.25 times the force is logged with 1 / 1.25 of it, and a late one earlier."""
    plain, strong = on_the_bench(), on_the_bench(effect("actuator_gain", actuator="motor", factor=1.25))
    assert strong["x"] == pytest.approx(plain["x"], abs=1e-12)
    noise = strong["f"] - plain["f"] / 1.25
    assert np.std(noise) < 0.3 and np.std(plain["f"]) > 20


def test_a_reading_that_drives_the_diagnosis_is_wrong_and_the_machine_is_not() -> None:
    plain, off = on_the_bench(), on_the_bench(effect("sensor_scale", channel="carriage", factor=1.1))
    assert off["x"] == pytest.approx(1.1 * plain["x"], abs=1e-12)
    assert off["f"] == pytest.approx(plain["f"], abs=1e-9)


def test_friction_by_load_follows_the_plants_own_motion() -> None:
    """It adds a share of the motor's force wherever the carriage moves, whichever way."""
    plain, rubbing = on_the_bench(), on_the_bench(effect("load_friction", joint="slide", share=0.2))
    moving = np.abs(np.gradient(plain["x"], plain["t"])) > 0.05
    more = (rubbing["f"] - plain["f"]) * np.sign(np.gradient(plain["x"], plain["t"]))
    assert np.median(more[moving]) > 1.0 and np.mean(more[moving] > -3) > 0.98


def test_sensors_have_noise_that_remembers_and_steps() -> None:
    said = "sensor.force = {noise = 1.0, correlation = 0.05, resolution = 0.5}"
    clean = on_the_bench(plant=PLANT.replace("{noise = 1.0}", "{}"))
    noisy = on_the_bench(plant=PLANT.replace("sensor.force = {noise = 1.0}", said))
    assert np.all(noisy["f"] % 0.5 == 0)
    own = noisy["f"] - clean["f"]
    assert 0.6 < np.std(own) < 1.4
    assert np.corrcoef(own[1:], own[:-1])[0, 1] == pytest.approx(np.exp(-1 / (200 * 0.05)), abs=0.08)


def test_a_reference_starts_at_rest_and_rests_in_its_knots() -> None:
    channels = parse_channel_map(drive().channels)
    motion = parse_plant(PLANT, "plant", channels).motion[1].reference["carriage"]
    time = np.linspace(0, 10, 2001)
    value = motion(time)
    assert value[0] == 0 and abs(value[1] - value[0]) < 1e-6
    after = time > LEAD
    exact = 0.15 * (np.sin(2 * np.pi * 0.3 * time + 0.5) - np.sin(0.5)) + 0.02 * np.sin(2 * np.pi * 1.3 * time)
    assert value[after] == pytest.approx(exact[after], abs=1e-12)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (
            lambda text: text.replace("sensor.force", "sensor.torque"),
            "sensor names torque; the map has carriage, force",
        ),
        (lambda text: text.replace("servo.slide", "servo.slope"), "servo names slope"),
        (lambda text: text.replace("servo.slide", "#"), "joint slide is driven, but has no"),
        (lambda text: text.replace("reference.carriage", "reference.cart"), "motion.reference names cart"),
        (lambda text: text.replace('part = "holdout"', 'part = "train"'), "one for holdout"),
        (lambda text: text.replace("rate = 200", "rate = 0"), "rate: "),
        (lambda text: text.replace("[2.5, 0.3]", "[0.5, 0.3]"), "times of knots must increase"),
        (lambda text: text.replace("rate = 200", "rates = 200"), "rate"),
    ],
)
def test_a_plant_that_does_not_fit_its_map_is_refused(change: Callable[[str], str], said: str) -> None:
    with pytest.raises(InputError, match=said):
        parse_plant(change(PLANT), "plant", parse_channel_map(drive().channels))


def test_a_sum_of_fields_is_no_channel_of_a_plant() -> None:
    channels = parse_channel_map(drive().channels.replace('field = "f"', "terms = {f = 1.0}"))
    with pytest.raises(InputError, match="channel force of the map is a sum of fields"):
        parse_plant(PLANT, "plant", channels)


def test_a_map_without_a_plant_is_refused(tmp_path: Path) -> None:
    (tmp_path / "map.toml").write_text(drive().channels)
    with pytest.raises(InputError, match=r"map.plant.toml says how"):
        MjcfBench.beside(tmp_path / "map.toml")


def test_what_no_recording_tells_from_another_effect_does_not_show() -> None:
    """A heavier lone carriage, a load on it and an inertia of its motor are the same to the last bit."""
    bench = drive()
    for name, entries in (
        ("payload", {"body": "carriage", "mass": 3.0}),
        ("body_mass", {"body": "carriage", "factor": 1.1}),
        ("armature", {"joint": "slide", "inertia": 3.0}),
    ):
        assert bench.visibility([effect(name, **entries)]) < 0.05
    friction = effect("coulomb_friction", joint="slide", force=10.0)
    assert bench.visibility([friction]) > bench.visible  # though asymmetric friction holds it
    assert bench.visibility([friction, effect("payload", body="carriage", mass=3.0)]) > 5
    assert bench.visibility([]) == 0
    heavier = {("body_mass", (("body", "carriage"),)), ("armature", (("joint", "slide"),))}
    assert heavier <= {*bench.alike(effect("payload", body="carriage", mass=3.0))}
    assert bench.alike(effect("payload", body="carriage", mass=1e-3)) == []  # nothing shows
    little = effect("asymmetric_dead_zone", actuator="motor", forward=1e-3, backward=1e-3)
    assert bench.alike(little) == [("dead_zone", (("actuator", "motor"),))]  # by another form it is no wrong name
    assert "viscous_joint_friction" not in [name for name, _ in bench.alike(friction)]


@pytest.mark.parametrize("name", KINDS)
def test_what_every_plant_has_and_the_model_lacks_hides_less_than_an_effect(name: str) -> None:
    """Elastic gears, another integrator, filters; noise that remembers alone makes 1.8 of what is declared."""
    bench = MjcfBench.beside(BENCHES / f"{name}.toml")
    model = linearise(_healthy(bench))
    residual, data = model.clean(model.residual(model.base)), model.data
    assert max(gap(residual, data.train), gap(residual, data.held_out)) < bench.visible


def test_an_effect_is_withheld_with_other_forms_of_it() -> None:
    assert {"asymmetric_friction", "dry_and_viscous_friction", "directional_friction"} <= {
        *family("coulomb_friction")[1:]
    }
    assert family("tip_payload") == ["tip_payload"]
    assert family("asymmetric_dead_zone") == ["asymmetric_dead_zone", "dead_zone"]


def test_clutter_is_small_of_other_kinds_and_elsewhere() -> None:
    bench = MjcfBench.beside(BENCHES / "six_axis_arm.toml")
    true = make_effect("coulomb_friction", {"joint": "axis2", "force": 5.0}, bench.sites)
    order = Order("single", ("coulomb_friction",), "payload")
    found = draw_clutter(4, order, [true], np.random.default_rng(0), bench.sites)
    assert len({one.id for one in found}) == 4 and not {"coulomb_friction", "payload"} & {one.id for one in found}
    assert len({one.site.key for one in (true, *found)}) == 5  # what acts at one place is told as one
    for one in found:
        scaled = [p.coordinate(one.values[name]) for name, p in one.declared.items() if name in one.free(one.site)]
        assert np.abs(scaled).max() <= CLUTTER[1] + 1e-9
    assert draw_clutter(0, order, [true], np.random.default_rng(0), bench.sites) == []
    crowded = draw_clutter(99, order, [true], np.random.default_rng(0), bench.sites)
    assert {one.id for one in crowded} < {*known_effects(bench.sites)} - {"coulomb_friction", "payload"}
    assert len(crowded) == len({one.site.key for one in crowded}) < 99


@pytest.mark.slow
def test_from_a_map_to_the_score(tmp_path: Path) -> None:
    """A set of two cases, one of them diagnosed by a process that can open its case and what is nominal alone."""
    cases, seal, answers = tmp_path / "cases", tmp_path / "seal.json", tmp_path / "answers"
    mix = {"single": 1.0, "withheld": 1.0}
    assert [*make_cases(2, b"everybody may read it", drive(), mix, cases, seal, clutter=2)] == [0, 1, 2]
    truth = json.loads(seal.read_text())["cases"]
    assert sorted(path.name for path in cases.iterdir()) == sorted(
        [*truth, "README.md", "answer.schema.json", "map.toml", "model.xml", "seal.sha256"]
    )
    for name, one in truth.items():
        assert len(one["clutter"]) == 2 and one["nuisances"][0]["id"] == "series_compliance"
        assert one["visibility"] >= drive().visible
        without = json.loads((cases / name / "withhold.json").read_text())["without"]
        assert (one["effects"][0]["id"] in without) == (one["class"] == "withheld")
        read = read_case(cases / name)
        assert read.data.training and len(read.data.recordings) == 2
        assert make_effect(one["effects"][0]["id"], one["effects"][0]["location"], read.system.sites())
    (single,) = (name for name, one in truth.items() if one["class"] == "single")
    answers.mkdir()
    (answers / f"{single}.json").write_text(solve(cases / single, most=1))
    assert read_answer(answers / f"{single}.json")["verdict"] != "consistent"
    outcomes = {o.case: o for o in score(cases, seal, answers).outcomes}
    assert outcomes[single].answer != "no answer" and len(outcomes) == 2
