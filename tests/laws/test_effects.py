"""Laws that every effect obeys, at every site of a boom and of an arm; a new file is tested the day it lands."""

import pickle
from copy import deepcopy
from functools import cache
from importlib import import_module
from inspect import isabstract
from pathlib import Path

import arm
import numpy as np
import pytest

from boom_mj.effects import (
    BOOM_SITES,
    Effect,
    ForceEffect,
    InputEffect,
    MachineEffect,
    ModelEffect,
    OutputEffect,
    Parameter,
    Site,
    effect_library,
    is_output,
    make_effect,
    parse_effect,
)
from boom_mj.errors import EffectError
from boom_mj.machine import load_machine
from boom_mj.mjcf import build
from boom_mj.recording import Recording
from boom_mj.sensors import ideal_signals, measure, noise_levels
from boom_mj.simulation import CATALOGUE, Trajectory, make_plant, run_experiment
from boom_mj.simulation.plant import with_effects
from boom_mj.systems.boom import BoomSystem
from boom_mj.systems.fidelity import Level
from boom_mj.systems.system import System
from boom_mj.testing import check_effect

BOOM = load_machine(Path(__file__).parents[2] / "models" / "boom36.toml")
SEEN_IN = ("slew_t", "sweep", "release_bow_vertical")
KINDS = list(effect_library().values())
OF_BOOMS = [kind for kind in KINDS if kind.allowed(BOOM_SITES)]
OF_MJCF = [kind for kind in KINDS if "boom" not in kind.needs]
AT_BOOM = [(kind, site) for kind in OF_BOOMS for site in kind.allowed(BOOM_SITES)]
LINE_HZ = 0.45
every_effect = pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.id)


def called(value: object) -> str:
    return value.id if isinstance(value, type) else ",".join(map(str, value.location.values()))


def sites(kind: type[Effect]) -> tuple[Site, ...]:
    """Wherever an effect can be: of a boom, then of the arm."""
    return *kind.allowed(BOOM_SITES), *kind.allowed(arm.system().sites())


def everywhere(kind: type[Effect]) -> list[Effect]:
    """Neutral, at each of its sites."""
    return [kind(site) for site in sites(kind)]


def typical(kind: type[Effect], site: Site) -> Effect:
    """All parameters at once at the last of their screening points, so that polar effects have an amplitude."""
    values: dict[str, float] = {}
    for point in kind.screening(site, (LINE_HZ,))[-1]:
        values |= point
    return kind(site, **values)


def at_work(kind: type[Effect]) -> list[Effect]:
    return [typical(kind, site) for site in sites(kind)]


# What an effect is


def test_ids_are_those_of_the_files() -> None:
    """One concrete class a file, called as the file is."""
    library = Path(import_module("boom_mj.effects.library").__path__[0])
    names = sorted(path.stem for path in library.glob("*.py") if path.stem != "__init__")
    for name in names:
        module = import_module(f"boom_mj.effects.library.{name}")
        own = [k for k in vars(module).values() if isinstance(k, type) and k.__module__ == module.__name__]
        assert [k.id for k in own if issubclass(k, Effect) and not isabstract(k)] == [name]
        assert effect_library()[name] in own
    assert list(effect_library()) == sorted(effect_library()) and set(names) <= set(effect_library())


@every_effect
def test_it_says_what_it_is(kind: type[Effect]) -> None:
    assert kind.__doc__ and kind.separating_experiment and sites(kind), f"{kind.id} is nowhere on these machines"
    if kind in OF_BOOMS:
        assert kind.separating_experiment in CATALOGUE


@every_effect
def test_it_is_confused_with_effects_that_there_are_both_ways(kind: type[Effect]) -> None:
    assert kind.confused_with
    for alike in kind.confused_with:
        assert alike in effect_library(), f"{kind.id} is confused with {alike}, which there is not"
        assert kind.id in effect_library()[alike].confused_with, f"{alike} does not say that it looks like {kind.id}"
    assert kind.id not in kind.confused_with and {*kind.special_cases} <= {*effect_library()}


@every_effect
def test_it_obeys_the_laws_that_other_packages_are_held_to(kind: type[Effect]) -> None:
    for known in (BOOM_SITES, arm.system().sites()):
        if kind.allowed(known):
            check_effect(kind, known, BOOM if known is BOOM_SITES else None)


@every_effect
def test_parameters_are_bounded(kind: type[Effect]) -> None:
    for site in sites(kind):
        declared = kind.parameters(site)
        assert declared and {*kind.free(site)} <= {*declared}
        for name, parameter in declared.items():
            assert parameter.low <= parameter.neutral <= parameter.high and parameter.unit
            for beyond in (parameter.low - 1, parameter.high + 1):
                if np.isfinite(beyond):
                    with pytest.raises(EffectError, match=name):
                        kind(site, **{name: beyond})
        with pytest.raises(EffectError, match="no parameter 'colour'"):
            kind(site, colour=1.0)


@every_effect
def test_a_scaled_parameter_is_the_parameter(kind: type[Effect]) -> None:
    for site in sites(kind):
        for name, parameter in kind.parameters(site).items():
            assert parameter.coordinate(parameter.neutral) == 0 and parameter.value(0.0) == parameter.neutral
            worth_finding = parameter.typical if parameter.inverse else parameter.neutral + parameter.typical
            assert parameter.coordinate(worth_finding) == pytest.approx(1)
            for value in spread(parameter):
                found = parameter.value(parameter.coordinate(value))
                assert found == pytest.approx(value, rel=1e-12, abs=1e-12 * abs(parameter.typical)), (name, site)


def spread(parameter: Parameter) -> np.ndarray:
    """Values from bound to bound; every decade of what has no upper one."""
    if np.isfinite(parameter.high):
        return np.linspace(parameter.low, parameter.high, 7)
    return np.r_[parameter.low * np.logspace(0, 6, 7), parameter.high]


@every_effect
def test_copies_are_equal(kind: type[Effect]) -> None:
    """In another process, too: by copy, by pickle, and by the text that people write; what they declare, too."""
    for effect in (*everywhere(kind), *at_work(kind)):
        unit = effect.basis(1.5)
        assert_same(effect, parse_effect(str(effect), known_beside(effect.site)))
        for one in (effect, unit) if unit else (effect,):  # text does not tell a unit: people give no gust a time
            assert_same(one, deepcopy(one))
            assert_same(one, pickle.loads(pickle.dumps(one)))


def known_beside(site: Site) -> tuple[Site, ...]:
    return BOOM_SITES if "boom" in site.tags else arm.system().sites()


def assert_same(one: Effect, other: Effect) -> None:
    assert other is not one and type(other) is type(one) and other.key == one.key
    assert other == one and hash(other) == hash(one) and other.cause == one.cause
    assert other.declared == one.declared and other.site.tags == one.site.tags


def test_a_unit_of_a_latent_input_is_another_effect() -> None:
    wind = make_effect("wind", {"mean_speed": 5.0})
    units = [wind.basis(1.5), wind.basis(2.0)]
    assert len({wind, *units}) == 3 and all(unit.cause == wind.cause for unit in units)
    assert {kind.id for kind in KINDS if kind(sites(kind)[0]).basis(1.5)} == {"wind"}


def test_effects_differ_by_kind_site_and_values() -> None:
    every = [effect for kind in KINDS for effect in (*everywhere(kind), *at_work(kind))]
    assert len({(e.site.tags, e) for e in every}) == len(every)
    assert all(a == a and hash(a) == hash(a) for a in every)


# What it does to a boom


def record(name: str, *effects: Effect) -> Recording:
    plan = CATALOGUE[name]
    return measure(run_experiment(make_plant(BOOM, 1, effects), plan), name, "", plan.duration)


@cache
def nominal(name: str) -> Recording:
    return record(name)


@pytest.mark.parametrize("kind", OF_BOOMS, ids=called)
def test_neutral_parameters_change_nothing_of_a_boom(kind: type[Effect]) -> None:
    boom = build(BOOM)
    effects = [kind(site) for site in kind.allowed(BOOM_SITES)]
    unpushed = [effect for effect in effects if not isinstance(effect, ForceEffect)]  # to push needs an actuator
    assert with_effects(boom, unpushed).boom.to_xml() == boom.to_xml()
    for effect in effects:
        assert not isinstance(effect, MachineEffect) or effect.change(BOOM) == BOOM
    found, wanted = record("slew_t", *effects), nominal("slew_t")
    assert found.signals.keys() == wanted.signals.keys()
    for name, signal in wanted.signals.items():
        assert found[name].values.tobytes() == signal.values.tobytes(), name


@pytest.mark.parametrize(("kind", "site"), AT_BOOM, ids=called)
def test_every_effect_moves_some_recording_of_a_boom(kind: type[Effect], site: Site) -> None:
    effect, levels, moved = typical(kind, site), noise_levels(BOOM), 0.0
    for name in SEEN_IN:
        found = record(name, effect)
        for signal, level in levels.items():
            change = np.abs(found[signal].values - nominal(name)[signal].values) / level
            moved = max(moved, float(np.nanmax(change)))
    assert 0.05 < moved < 1e4  # the torsion of the last link hardly matters


# What it does to an arm


def predicted(*effects: Effect) -> np.ndarray:
    return arm.predictor().predict([effects], Level(1.0))[0]


@pytest.mark.parametrize("kind", OF_MJCF, ids=called)
def test_neutral_parameters_change_nothing_of_an_arm(kind: type[Effect]) -> None:
    for site in kind.allowed(arm.system().sites()):
        effect = kind(site)
        if isinstance(effect, ModelEffect):
            spec = arm.system().spec.copy()
            effect.edit(spec, None)
            assert spec.to_xml() == arm.system().spec.to_xml(), effect
        assert predicted(effect).tobytes() == predicted().tobytes(), effect


@pytest.mark.parametrize("kind", OF_MJCF, ids=called)
def test_every_parameter_moves_something_of_an_arm(kind: type[Effect]) -> None:
    for site in kind.allowed(arm.system().sites()):
        effect = typical(kind, site)
        moved = predicted(effect)
        assert np.isfinite(moved).all() and np.abs(moved - predicted()).max() > 1e-9, effect
        for name, parameter in effect.declared.items():
            other = kind(site, **{**effect.values, name: parameter.neutral})
            assert np.abs(predicted(other) - moved).max() > 1e-12, f"{name} of {effect}"


# What it does by its type


@cache
def motion() -> Trajectory:
    plan = CATALOGUE["release_bow_vertical"]
    return run_experiment(make_plant(BOOM), plan.model_copy(update={"duration": 12.0}))


@pytest.mark.parametrize("kind", [kind for kind in KINDS if issubclass(kind, OutputEffect)], ids=called)
def test_signals_that_it_does_not_touch_are_the_same_objects(kind: type[Effect]) -> None:
    """So that what was made of them before is known; and signals that it is given stay what they are."""
    log = arm.predictor().data.recordings[0]
    machines: dict[str, tuple[System, dict]] = {
        "boom": (BoomSystem(BOOM), ideal_signals(motion())),
        "mjcf": (arm.system(), arm.system().simulate((), Level(1.0), log)),
    }
    for site in sites(kind):
        if not is_output(kind(site)):  # of a channel that drives
            continue
        system, dense = machines["boom" if "boom" in site.tags else "mjcf"]
        points = [point for group in kind.screening(site, (LINE_HZ,)) for point in group]
        for effect in (kind(site), typical(kind, site), *(kind(site, **point) for point in points)):
            before = {name: signal.values.copy() for name, signal in dense.items()}
            found = system.observe((effect,), dense)
            assert found.keys() == dense.keys() and all(np.array_equal(before[n], dense[n].values) for n in dense)
            touched = {name for name in found if found[name] is not dense[name]}
            if effect != kind(site):
                own = {name for name in touched if not np.array_equal(found[name].values, before[name])}
                assert touched == own, f"{effect} copies {touched - own}"
            else:
                assert all(np.array_equal(found[name].values, before[name]) for name in found), effect


@pytest.mark.parametrize("kind", [kind for kind in KINDS if issubclass(kind, InputEffect)], ids=called)
def test_what_went_in_is_known_from_what_comes_out(kind: type[Effect]) -> None:
    time = np.arange(0, 10, 0.01)
    for true in (2 + np.sin(time), np.sin(time)):
        for effect in (*everywhere(kind), *at_work(kind)):
            assert isinstance(effect, InputEffect)
            error = np.abs(effect.invert(time, effect.apply(time, true)) - true)[50:-50]
            assert error.max() <= lost(effect), effect


def lost(effect: Effect) -> float:
    """What an inverse may be off by: rounding, but for what is gone and what is between samples."""
    match effect.id:
        case "quantisation":  # which of the values that round to a step it was is gone
            return 0.5 * effect.values["step"] + 1e-12
        case "dead_zone" | "asymmetric_dead_zone":  # what is within it is gone, its edges are smoothed
            return max(effect.values.values()) + 1e-12
        case "actuator_delay" | "sensor_delay":  # twice between samples 0.01 s apart, linearly: a curvature of 1
            return 2 * 0.01**2 / 8 + 1e-12
        case "actuator_lag" | "low_pass" | "second_order_low_pass":  # its slope lies half a sample off: a slope of 1
            return 0.01 / 2
        case "joint_sensor_nonlinearity":  # a fixed point: each step takes all but a hundredth of what is left
            return 1e-7
    return 1e-12
