"""Laws that every effect obeys; a new file in the library is tested the day it lands."""

from collections.abc import Iterator
from pathlib import Path

import mujoco
import pytest

from boom_mj.effects import Effect, ModelEffect, Parameter, effect, library, parse_effect
from boom_mj.errors import EffectError
from boom_mj.machine import Machine, load_machine
from boom_mj.mjcf import build

BOOM = load_machine(Path(__file__).parents[2] / "models" / "boom36.toml")


class HeavyTip(ModelEffect):
    """A stand-in while the library is empty: a mass at the tip."""

    id = "heavy_tip"
    parameters = {"mass": Parameter("kg", 0.0, 0.0, 500.0)}  # noqa: RUF012

    def edit(self, spec: mujoco.MjSpec, machine: Machine) -> None:
        """Adds to the last link's mass."""
        body = spec.body("link5_2")
        body.mass = body.mass + self.values["mass"]


def everything() -> list[type[Effect]]:
    return [HeavyTip, *library().values()]


@pytest.fixture
def with_heavy_tip(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    monkeypatch.setattr(effect, "library", lambda: {"heavy_tip": HeavyTip, **library()})
    yield


@pytest.mark.parametrize("kind", everything(), ids=lambda kind: kind.id)
def test_neutral_parameters_change_nothing(kind: type[Effect]) -> None:
    term, boom = kind(), build(BOOM)
    before = boom.to_xml()
    if isinstance(term, ModelEffect):
        term.edit(boom.spec, BOOM)
    assert boom.to_xml() == before


@pytest.mark.parametrize("kind", everything(), ids=lambda kind: kind.id)
def test_parameters_are_bounded_and_documented(kind: type[Effect]) -> None:
    assert kind.__doc__ and kind.parameters
    for name, bound in kind.parameters.items():
        assert bound.low <= bound.neutral <= bound.high
        with pytest.raises(EffectError, match=name):
            kind(**{name: bound.high + 1})


def test_text_becomes_an_effect(with_heavy_tip: None) -> None:
    boom = build(BOOM)
    before = sum(boom.compile().body_mass)
    term = parse_effect("heavy_tip:mass=50")
    assert isinstance(term, ModelEffect)
    term.edit(boom.spec, BOOM)
    assert sum(boom.compile().body_mass) == pytest.approx(before + 50)


@pytest.mark.parametrize(
    ("text", "told"), [("ghost", "heavy_tip"), ("heavy_tip:weight=1", "mass"), ("heavy_tip:mass=lots", "number")]
)
def test_bad_effects_are_named(with_heavy_tip: None, text: str, told: str) -> None:
    with pytest.raises(EffectError, match=told):
        parse_effect(text)
