"""What single effects do besides the laws that all obey, and effects written as text."""

from pathlib import Path

import numpy as np
import pytest

from boom_mj.effects import (
    BOOM_SITES,
    Effect,
    ForceEffect,
    Motion,
    effect_library,
    make_effect,
    parse_effect,
)
from boom_mj.effects.library.end_hose import DAMPING
from boom_mj.errors import EffectError
from boom_mj.estimation.latent_input import KNOT_S
from boom_mj.machine import load_machine
from boom_mj.simulation import make_plant

BOOM = load_machine(Path(__file__).parents[2] / "models" / "boom36.toml")


def test_what_tones_of_a_pulsation_combine_to_pushes_as_they_do_together() -> None:
    """Points push in proportion to their weights, and so does what they become: an amplitude, a phase, a harmonic."""
    kind, time = effect_library()["pump_pulsation"], np.linspace(0, 9, 200)
    site = next(site for site in kind.allowed(BOOM_SITES) if site.location["direction"] == "vertical")
    line, (alone, with_harmonic) = 0.9, kind.screening(site, (0.9,))
    phase, size, ratio = 0.7, 3.0, 0.4
    tone = size * np.array([np.cos(phase), np.sin(phase)])
    harmonic = ratio * size * np.array([np.cos(2 * phase), np.sin(2 * phase)])

    def force(values: dict[str, float]) -> np.ndarray:
        return pushed(kind(site, **values), time, np.zeros((len(time), 5)))["tip"][:, 2]

    for group, weights in (
        (alone, tone),
        (with_harmonic, np.r_[tone, 0 * harmonic]),
        (with_harmonic, np.r_[tone, harmonic]),
    ):
        together = sum(w * force({"harmonic_ratio": 0.0, **point}) for w, point in zip(weights, group))
        assert force(kind.combine(site, group, weights)) == pytest.approx(together, abs=1e-9)
    assert {point["frequency"] for point in with_harmonic} == {line / 2, line}


def pushed(effect: Effect, time: np.ndarray, joints: np.ndarray) -> dict[str, np.ndarray]:
    """Forces at joint angles (n, 5)."""
    assert isinstance(effect, ForceEffect)
    position = {f"joint{k + 1}": column for k, column in enumerate(joints.T)}
    return dict(effect.force(Motion(time, position, machine=BOOM)))


def test_units_of_gusts_add_up_to_a_stronger_wind() -> None:
    """Hats a knot apart sum to one, and each has the pressure of the size worth finding."""
    time, joints = np.linspace(1, 2, 40), np.tile([0.1, 1.0, -0.5, 0.2, 0.0], (40, 1))
    wind, stronger = (make_effect("wind", {"mean_speed": v, "direction": 0.4}) for v in (6.0, np.hypot(6, 5)))
    mean = pushed(wind, time, joints)
    units = [pushed(wind.basis(at), time, joints) for at in KNOT_S * np.arange(round(3 / KNOT_S))]
    for site, force in pushed(stronger, time, joints).items():
        assert mean[site] + sum(unit[site] - mean[site] for unit in units) == pytest.approx(force)
    speed = 6.0 / np.hypot(1, 0.15)  # the mean of its square is 36
    expected = {"mean_speed": speed, "gust_strength": 0.15}
    assert wind.with_latent(2 * 6.0**2 * 0.15 / 5.0**2) == pytest.approx(expected)


def test_text_becomes_an_effect() -> None:
    softer = parse_effect("link_stiffness:link=3,axis=w,factor=0.9")
    assert softer.location == {"link": 3, "axis": "w"} and softer.values == {"factor": 0.9}
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
        ("coulomb_friction:joint=2,force=1", "cannot have the effect coulomb_friction"),
    ],
)
def test_bad_effects_are_named(text: str, told: str) -> None:
    with pytest.raises(EffectError, match=told):
        parse_effect(text)


@pytest.mark.parametrize("link", [2, 3, 4, 5])
def test_a_longer_link_reaches_as_much_farther(link: int) -> None:
    longer = make_effect("link_length", {"link": link, "error": 0.3})
    plants = make_plant(BOOM, 2), make_plant(BOOM, 2, [longer])
    reach = [plant.tip(np.zeros(plant.model.nq))[0] for plant in plants]
    assert reach[1] - reach[0] == pytest.approx(0.3, abs=1e-3)


def test_a_hose_swings_with_its_own_share_of_damping() -> None:
    model = make_plant(BOOM, 1, [make_effect("end_hose", {"mass": 30.0})]).model
    length, (hinge,) = BOOM.end_hose.length, model.joint("hose_pitch").dofadr
    critical = 2 * 30.0 * length**2 * np.sqrt(BOOM.gravity / length)
    assert model.dof_damping[hinge] == pytest.approx(DAMPING * critical)
