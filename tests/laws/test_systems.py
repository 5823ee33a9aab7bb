"""Laws that every system obeys: the boom, and an arm as one MJCF file among all."""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import arm
import mujoco
import numpy as np
import pytest

from boom_mj.diagnosis.linearisation import of_size
from boom_mj.effects import make_effect
from boom_mj.errors import BoomError
from boom_mj.logs import read_log
from boom_mj.machine import load_machine, parse_machine
from boom_mj.recording import Recording, Signal, window
from boom_mj.systems.boom import BoomSystem
from boom_mj.systems.boom.system import COARSE, FINE, MIDDLE
from boom_mj.systems.fidelity import Level
from boom_mj.systems.mjcf import MjcfSystem
from boom_mj.systems.predictor import Predictor, dataset_of
from boom_mj.systems.system import (
    Corrects,
    Designs,
    Hypothesis,
    LinearResponse,
    ResidualForces,
    System,
    separating_experiments,
)
from boom_mj.testing import check_system

ROOT = Path(__file__).parents[2]
FILE = ROOT / "models" / "boom36.toml"
EIGHT = 8


@dataclass(frozen=True)
class Case:
    """A system and what it is tried with.

    Attributes:
        make: another one, that has simulated nothing.
        hypotheses: those that are simulated; each says otherwise than the nominal machine.
        impossible: one that has no simulation.
    """

    system: System
    make: Callable[[], System]
    log: Recording
    hypotheses: tuple[Hypothesis, ...]
    impossible: Hypothesis


@cache
def short_log() -> Recording:
    log = read_log(ROOT / "logs" / "independent_release_stretched_vertical.mcap")
    return replace(log, signals={name: window(signal, 7.0, 9.0) for name, signal in log.signals.items()})


def boom() -> BoomSystem:
    text = FILE.read_text()
    return BoomSystem(parse_machine(text), text)


def arm_again() -> MjcfSystem:
    old, data = arm.system(), arm.predictor().data
    noise = {name: float(level[0]) for name, level in old.facts.noise.items()}
    return MjcfSystem(old.spec, old.channels, data.recordings[: data.training], noise)


@cache
def case(kind: str) -> Case:
    if kind == "boom":
        load, wind = make_effect("tip_payload", {"mass": 40.0}), make_effect("wind", {"mean_speed": 9.0})
        wave = make_effect("joint_sensor_nonlinearity", {"joint": 2, "amplitude": 0.004})
        return Case(boom(), boom, short_log(), ((load,), (wind,), (load, wind), (wave,)), (load, load))
    system, log = arm.system(), arm.predictor().data.recordings[0]
    entries = (
        ("body_mass", {"body": "fore", "factor": 1.2}),
        ("stribeck_friction", {"joint": "shoulder", "excess": 0.2}),
        ("sensor_delay", {"channel": "angle", "delay": 0.02}),
        ("actuator_gain", {"actuator": "spinner", "factor": 1.2}),
    )
    effects = [make_effect(name, values, system.sites()) for name, values in entries]
    load = make_effect("payload", {"body": "fore", "mass": 0.1}, system.sites())
    return Case(system, arm_again, log, (*((effect,) for effect in effects), tuple(effects)), (load, load))


every_system = pytest.mark.parametrize("kind", ["boom", "mjcf"])


def content(signals: dict[str, Signal]) -> dict[str, tuple[bytes, bytes]]:
    return {name: (signal.time.tobytes(), signal.values.tobytes()) for name, signal in signals.items()}


@every_system
def test_it_says_the_same_twice_and_on_eight_threads(kind: str) -> None:
    """What it has simulated before and what is simulated beside it do not matter."""
    tried = case(kind)
    level = tried.system.facts.fidelity.coarse
    hypotheses = [(), *tried.hypotheses]
    once = [content(tried.make().simulate(h, level, tried.log)) for h in hypotheses]
    assert len({str(sorted(one.items())) for one in once}) == len(hypotheses)
    again = tried.make()
    assert [content(again.simulate(h, level, tried.log)) for h in (*hypotheses, *hypotheses)] == [*once, *once]
    fresh = tried.make()
    with ThreadPoolExecutor(EIGHT) as threads:
        found = threads.map(lambda h: content(fresh.simulate(h, level, tried.log)), EIGHT * hypotheses)
        assert list(found) == EIGHT * once


@every_system
def test_it_obeys_the_laws_that_other_packages_are_held_to(kind: str) -> None:
    check_system(case(kind).system, case(kind).log)


@every_system
def test_sites_are_unique_as_they_are_written(kind: str) -> None:
    sites = case(kind).system.sites()
    assert len({*sites}) == len(sites)
    assert len({str(sorted(site.location.items())) for site in sites}) == len(sites)
    assert all(kind in site.tags for site in sites)
    assert case(kind).make().sites() == sites


@every_system
def test_nuisances_vanish_at_zero(kind: str) -> None:
    system, log = case(kind).system, case(kind).log
    nuisances, level = system.nuisances(), system.facts.fidelity.coarse
    gone = of_size(nuisances, np.zeros(len(nuisances)))
    assert gone
    assert all(value == effect.declared[name].neutral for effect in gone for name, value in effect.values.items())
    nominal = system.simulate((), level, log)
    assert content(system.simulate(gone, level, log)) == content(nominal)
    observed = system.observe(gone, nominal)
    assert all(np.array_equal(observed[name].values, nominal[name].values) for name in nominal)


@every_system
def test_a_nuisance_is_as_many_of_its_hypothesis_as_its_deviation_says(kind: str) -> None:
    for nuisance in case(kind).system.nuisances():
        assert nuisance.deviation > 0 and nuisance.hypothesis
        (*found,) = of_size([nuisance], np.array([1 / nuisance.deviation]))
        assert {e.cause for e in found} == {e.cause for e in nuisance.hypothesis}
        for effect, whole in zip(found, nuisance.hypothesis):
            assert dict(effect.values) == pytest.approx(dict(whole.values))
        assert not nuisance.conditional_on(nuisance.hypothesis).hypothesis
        assert nuisance.conditional_on(()) == nuisance


@every_system
def test_facts_fit_what_it_simulates(kind: str) -> None:
    system, log = case(kind).system, case(kind).log
    facts, line = system.facts, system.timeline(log)
    assert facts.kind == kind and facts.block_s > 0 and facts.correlation_s > facts.block_s
    edges = [edge for _, edge in facts.bands_hz]
    assert edges == sorted(edges) and edges[-1] == np.inf
    dense = system.simulate((), facts.fidelity.rough, log)
    groups = {}
    for name, noise in facts.noise.items():
        assert dense[name].values.shape == (len(dense[name].time), len(noise)) and (noise > 0).all()
        assert dense[name].time[0] == 0 and dense[name].time[-1] >= line.duration_s - 1e-9
        assert np.isfinite(dense[name].values).all()
        for column in range(len(noise)):
            place = system.channel(name, column)
            groups.setdefault(place.group, place)
            known = groups[place.group]
            assert (place.sensor, place.part, place.direction) == (known.sensor, known.part, known.direction)
    assert facts.line_signal is None or facts.line_signal in dense
    blocks = np.arange(0, line.duration_s, facts.block_s)
    assert {*line.phases()} <= {*facts.wording.phases} and len(line.phases()) >= len(blocks)
    assert len(line.coordinates(blocks)) == len(blocks) and np.isfinite(line.coordinates(blocks)).all()
    assert (
        facts.wording.zero_offset in {e.id for n in system.nuisances() for e in n.hypothesis} or not facts.oscillatory
    )


@every_system
def test_a_hypothesis_that_has_no_simulation_is_refused_and_predicted_as_unknown(kind: str) -> None:
    tried = case(kind)
    level = tried.system.facts.fidelity.rough
    with pytest.raises(BoomError, match=tried.impossible[0].id):
        tried.system.simulate(tried.impossible, level, tried.log)
    predictor = Predictor(tried.system, dataset_of(tried.system, [tried.log], 1), threads=1)
    failed, nominal = predictor.predict([tried.impossible, ()], level)
    assert np.isnan(failed).all() and np.array_equal(np.isfinite(nominal), predictor.data.used)


def test_what_a_system_can_beyond_that_is_told_by_its_type() -> None:
    beyond = (ResidualForces, Designs, Corrects, LinearResponse)
    assert [isinstance(case("boom").system, one) for one in beyond] == [True] * 4
    assert [isinstance(case("mjcf").system, one) for one in beyond] == [False, False, True, False]


@pytest.mark.parametrize("level", [COARSE, MIDDLE, FINE])
def test_a_motion_that_the_step_of_the_stretched_boom_does_not_bear_has_a_shorter_one(level: Level) -> None:
    """An undamped cylinder whose fastest mode is at the edge of what the step bears."""
    soft = make_effect("hydraulic_compliance", {"joint": 3, "stiffness": 2.3e7, "damping_factor": 0.0})
    signals = boom().simulate((soft,), level, short_log())
    assert all(np.isfinite(signal.values).all() for signal in signals.values())
    assert np.ptp(signals["markers"].values, axis=0).max() < 5


def test_an_angle_error_moves_the_boom_as_zero_offsets_do() -> None:
    """Known without simulation: a constant error is the zero offset itself, others are it at every moment."""
    system = boom()
    data = dataset_of(system, [short_log()], 1)
    nuisances, rng = system.nuisances(), np.random.default_rng(0)
    columns = rng.standard_normal((len(data.time), len(nuisances)))
    for joint in range(5):
        (offset,) = nuisances[joint].hypothesis
        found = system.column(offset, data, columns)
        assert found == pytest.approx(columns[:, joint] / nuisances[joint].deviation)
    wave = make_effect("joint_sensor_nonlinearity", {"joint": 2, "amplitude": 0.004, "periods": 3.0})
    angles = short_log()["joint/position"]
    error = 0.004 * np.sin(3 * np.interp(data.time, angles.time - angles.time[0], angles.values[:, 1]))
    (offset,) = nuisances[1].hypothesis
    expected = columns[:, 1] / nuisances[1].deviation * error / offset.values["offset"]
    assert system.column(wave, data, columns) == pytest.approx(expected, rel=1e-4, abs=1e-9)
    assert system.column(make_effect("tip_payload", {"mass": 1.0}), data, columns) is None


def test_a_corrected_model_holds_what_mjcf_can_and_names_the_rest() -> None:
    system = arm.system()
    heavier, late = (
        make_effect(name, values, system.sites())
        for name, values in (
            ("body_mass", {"body": "fore", "factor": 1.5}),
            ("actuator_delay", {"actuator": "spinner", "delay": 0.01}),
        )
    )
    text = system.corrected((heavier, late))
    model, nominal = mujoco.MjModel.from_xml_string(text), system.spec.copy().compile()
    assert model.body("fore").mass[0] == pytest.approx(1.5 * nominal.body("fore").mass[0])
    assert f"<!-- cause, not in the model: {late} -->" in text and f"<!-- cause: {heavier} -->" in text
    sites = [site for site in system.sites() if "measured" in site.tags and "joint" in site.location]
    rubbing = make_effect("directional_friction", {**sites[0].location, "force": 1.0, "forward": 0.2}, sites)
    assert f"<!-- cause, in part not in the model: {rubbing} -->" in system.corrected((rubbing,))
    why = {(heavier, "id"): "suspect, not sure: probability 0.10", (heavier, "factor"): "estimate; 95 % 1.4 .. 1.6"}
    text = system.corrected((heavier,), reasons=why)
    assert f"<!-- suspect, not sure: probability 0.10: {heavier}; factor: estimate; 95 % 1.4 .. 1.6 -->" in text
    assert mujoco.MjModel.from_xml_string(system.corrected(())).nv == nominal.nv


def test_what_separates_rivals_is_what_the_library_says() -> None:
    sites = arm.system().sites()
    dry = make_effect("coulomb_friction", {"joint": "shoulder", "force": 1.0}, sites)
    gain = make_effect("actuator_gain", {"actuator": "spinner", "factor": 1.1}, sites)
    told = separating_experiments([(dry,), (gain,)])
    assert told == f"{gain.separating_experiment} and {dry.separating_experiment}"
    assert separating_experiments([]) is None


def test_a_machine_file_that_holds_effects_is_simulated_with_them() -> None:
    system = boom()
    load = make_effect("tip_payload", {"mass": 40.0})
    loaded = BoomSystem(parse_machine(system.corrected((load,))))
    level, log = system.facts.fidelity.rough, short_log()
    assert content(loaded.simulate((), level, log)) == content(system.simulate((load,), level, log))
    assert load_machine(FILE).effect == ()
