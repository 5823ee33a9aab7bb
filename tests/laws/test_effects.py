"""Laws that every effect obeys; a new file in the library is tested the day it lands."""

from functools import cache
from pathlib import Path

import numpy as np
import pytest

from boom_mj.effects import Effect, LoadEffect, effect_library, parse_effect
from boom_mj.effects.effect import KNOT
from boom_mj.errors import EffectError
from boom_mj.machine import load_machine
from boom_mj.mjcf import build
from boom_mj.recording import Recording
from boom_mj.sensors import measure
from boom_mj.simulation import CATALOGUE, Experiment, make_plant, run_experiment
from boom_mj.simulation.plant import with_effects

BOOM = load_machine(Path(__file__).parents[2] / "models" / "boom36.toml")
SEEN_IN = ("slew_t", "sweep", "release_bow_vertical")
KINDS = list(effect_library().values())
PLACES = [(kind, place) for kind in KINDS for place in kind.locations()]


def called(value: object) -> str:
    return value.id if isinstance(value, type) else ",".join(map(str, value.values()))


@cache
def experiment(name: str) -> Experiment:
    return CATALOGUE[name]


def record(name: str, *effects: Effect) -> Recording:
    plan = experiment(name)
    return measure(run_experiment(make_plant(BOOM, 1, effects), plan), name, "", plan.duration)


@cache
def nominal(name: str) -> Recording:
    return record(name)


def typical(kind: type[Effect], place: dict) -> Effect:
    """All knobs at once at the last of their probes, so that polar effects have an amplitude."""
    values: dict[str, float] = {}
    for probe in kind.probes(place, (0.45,))[-1]:
        values |= probe
    return kind(place, **values)


@pytest.mark.parametrize("kind", KINDS, ids=called)
def test_neutral_parameters_change_nothing(kind: type[Effect]) -> None:
    boom = build(BOOM)
    effects = [kind(place) for place in kind.locations()]
    assert with_effects(boom, [e for e in effects if not hasattr(e, "push")]).boom.to_xml() == boom.to_xml()
    found, wanted = record("slew_t", *effects), nominal("slew_t")
    for name, signal in wanted.signals.items():
        assert np.array_equal(found[name].values, signal.values, equal_nan=True), name


@pytest.mark.parametrize(("kind", "place"), PLACES, ids=called)
def test_every_effect_moves_some_recording(kind: type[Effect], place: dict) -> None:
    from boom_mj.sensors import noise_levels

    term, levels, moved = typical(kind, place), noise_levels(BOOM), 0.0
    for name in SEEN_IN:
        found = record(name, term)
        for signal, level in levels.items():
            change = np.abs(found[signal].values - nominal(name)[signal].values) / level
            moved = max(moved, float(np.nanmax(change)))
    assert 0.05 < moved < 1e4  # the torsion of the last link hardly matters


@pytest.mark.parametrize("kind", KINDS, ids=called)
def test_parameters_are_bounded_and_documented(kind: type[Effect]) -> None:
    assert kind.__doc__ and kind.parameters and kind.told_by in CATALOGUE
    place = kind.locations()[0]
    for name, bound in kind.parameters.items():
        assert bound.low <= bound.neutral <= bound.high
        assert bound.value(bound.coordinate(bound.value(0.7))) == pytest.approx(bound.value(0.7))
        with pytest.raises(EffectError, match=name):
            kind(place, **{name: bound.low - 1})


def test_what_pulsations_blend_into_pushes_as_they_do_together() -> None:
    """Probes push in proportion to their weights, and so does what they become: an amplitude, a phase, a harmonic."""
    kind, place, time = effect_library()["pump_pulsation"], {"direction": "vertical"}, np.linspace(0, 9, 200)
    line, (alone, with_harmonic) = 0.9, kind.probes({}, (0.9,))
    phase, size, ratio = 0.7, 3.0, 0.4
    tone = size * np.array([np.cos(phase), np.sin(phase)])
    harmonic = ratio * size * np.array([np.cos(2 * phase), np.sin(2 * phase)])

    def force(values: dict[str, float]) -> np.ndarray:
        return kind(place, **values).push(BOOM, time, np.zeros((len(time), 5)))["tip"][:, 2]

    for group, weights in (
        (alone, tone),
        (with_harmonic, np.r_[tone, 0 * harmonic]),
        (with_harmonic, np.r_[tone, harmonic]),
    ):
        together = sum(w * force({"harmonic_ratio": 0.0, **probe}) for w, probe in zip(weights, group))
        assert force(kind.blend(group, weights)) == pytest.approx(together, abs=1e-9)
    assert {probe["frequency"] for probe in with_harmonic} == {line / 2, line}


def test_pulses_of_gusts_add_up_to_a_stronger_wind() -> None:
    """Hats a knot apart sum to one, and each has the pressure of the size worth finding."""
    time, joints = np.linspace(1, 2, 40), np.tile([0.1, 1.0, -0.5, 0.2, 0.0], (40, 1))
    wind, stronger = (effect_library()["wind"]({}, mean_speed=speed, direction=0.4) for speed in (6.0, np.hypot(6, 5)))
    assert isinstance(wind, LoadEffect) and isinstance(stronger, LoadEffect)
    mean = wind.push(BOOM, time, joints)
    pulses = [wind.pulse(at).push(BOOM, time, joints) for at in KNOT * np.arange(round(3 / KNOT))]
    for site, force in stronger.push(BOOM, time, joints).items():
        assert mean[site] + sum(pulse[site] - mean[site] for pulse in pulses) == pytest.approx(force)
    speed = 6.0 / np.hypot(1, 0.15)  # the mean of its square is 36
    assert wind.course(2 * 6.0**2 * 0.15 / 5.0**2) == pytest.approx({"mean_speed": speed, "gust_strength": 0.15})


def test_text_becomes_an_effect() -> None:
    term = parse_effect("link_stiffness:link=3,axis=w,factor=0.9")
    assert term.location == {"link": 3, "axis": "w"} and term.values == {"factor": 0.9}
    mass = [sum(make_plant(BOOM, 1, e).model.body_mass) for e in ([], [parse_effect("tip_payload:mass=50")])]
    assert mass[1] - mass[0] == pytest.approx(50)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("ghost", "tip_payload"),
        ("tip_payload:weight=1", "mass"),
        ("tip_payload:mass=lots", "number"),
        ("tip_payload:mass", "key=value"),
        ("link_mass:link=7,factor=1.1", "2, 3, 4, 5"),
    ],
)
def test_bad_effects_are_named(text: str, told: str) -> None:
    with pytest.raises(EffectError, match=told):
        parse_effect(text)
