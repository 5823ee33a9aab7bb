"""Effects of other files and packages: they compete like ours, and what breaks a law or takes an id is refused."""

import subprocess
import sys
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from boom_mj.blind.sampling import MIX, orders
from boom_mj.effects import Equipped, builtin, effect_library, load_effects, parse_effect, registry
from boom_mj.errors import EffectError, EffectWarning
from boom_mj.machine import load_machine
from boom_mj.simulation import make_plant
from boom_mj.testing import check_effect

BOOM = load_machine("boom36")
pytestmark = pytest.mark.usefixtures("own_files")
ROPE = '''
import numpy as np
from boom_mj.effects import ForceEffect, Parameter

class TipRope(ForceEffect):
    """A rope that someone left tied to the tip."""

    id = "{name}"
    needs = frozenset({{"boom"}})
    table = {{"force": Parameter("N", 0.0, -2000.0, 2000.0, 50.0)}}
    confused_with = ("{alike}",)
    separating_experiment = "slew_tour"

    def force(self, motion):
        return {{"tip": np.outer(np.full(len(motion.time), self.values["force"]), [0.0, 1.0, 0.0])}}
'''


def file(folder: Path, text: str = ROPE, name: str = "tip_rope", alike: str = "wind") -> Path:
    path = folder / "rope.py"
    path.write_text(text.format(name=name, alike=alike) if text is ROPE else text)
    return path


def test_an_effect_of_a_file_is_one_of_the_library(tmp_path: Path) -> None:
    path = file(tmp_path)
    (kind,) = load_effects(path).values()
    assert effect_library()["tip_rope"] is kind and [*load_effects(path).values()] == [kind]
    assert [*effect_library()] == sorted({*builtin(), "tip_rope"}) and "tip_rope" not in builtin()
    assert make_plant(BOOM, 1, [parse_effect("tip_rope:force=100")]).model.actuator("push_tip_y").id >= 0
    check_effect(kind, machine=BOOM)


def test_other_processes_have_the_files_at_hand(tmp_path: Path) -> None:
    load_effects(file(tmp_path))
    with ProcessPoolExecutor(1, get_context("spawn")) as others:
        found = others.submit(Equipped(parse_effect), "tip_rope:force=7").result()
    assert found == parse_effect("tip_rope:force=7")


def test_blind_cases_are_drawn_of_our_own_effects_alone(tmp_path: Path) -> None:
    before = orders(60, MIX, np.random.default_rng(0))
    load_effects(file(tmp_path))
    assert orders(60, MIX, np.random.default_rng(0)) == before


@pytest.mark.parametrize(
    ("text", "told"),
    [
        (ROPE.replace("{name}", "wind").format(alike="wind"), "two effects are called wind: .*wind.* and of .*rope.py"),
        ("import nothing_of_the_kind", "cannot be run: ModuleNotFoundError"),
        ("x = 1", "defines no effect"),
        (ROPE.replace('    id = "{name}"\n', "").format(alike="wind"), "TipRope has no id"),
    ],
)
def test_files_that_are_no_effects_leave_the_library_as_it_is(tmp_path: Path, text: str, told: str) -> None:
    before = dict(effect_library())
    with pytest.raises(EffectError, match=told):
        load_effects(file(tmp_path, text))
    assert dict(effect_library()) == before
    with pytest.raises(EffectError, match="no Python file"):
        load_effects(tmp_path / "nowhere.py")


def test_what_a_package_offers_is_loaded_or_warned_of(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (kind,) = load_effects(file(tmp_path)).values()
    registry._files.clear()

    def broken() -> None:
        raise ImportError("no rope")

    points = [SimpleNamespace(name="rope", load=lambda: kind), SimpleNamespace(name="broken", load=broken)]
    monkeypatch.setattr(registry, "entry_points", lambda group: points)
    effect_library.cache_clear()
    with pytest.warns(EffectWarning, match="entry point broken cannot be loaded: no rope"):
        assert effect_library()["tip_rope"] is kind


@pytest.mark.parametrize(
    ("old", "new", "law"),
    [
        ('"{alike}"', '"ghost"', "ghost are none"),
        ('"""A rope that someone left tied to the tip."""', "", "docstring"),
        ("2000.0, 50.0", "-1.0, 50.0", "low <= neutral <= high"),
        ('needs = frozenset({{"boom"}})', 'needs = frozenset({{"moon"}})', "can be somewhere"),
        (
            "    def force(self",
            "    def __deepcopy__(self, memo):\n        return type(self)(force=7.0)\n\n    def force(self",
            "itself when it is copied",
        ),
    ],
)
def test_what_breaks_a_law_is_told(tmp_path: Path, old: str, new: str, law: str) -> None:
    text = ROPE.replace(old, new).format(name="tip_rope", alike="wind")
    with pytest.raises(EffectError, match=law):
        (kind,) = load_effects(file(tmp_path, text)).values()
        check_effect(kind, machine=BOOM)


def test_a_neutral_value_that_changes_the_model_is_told(tmp_path: Path) -> None:
    text = '''
from boom_mj.effects import ModelEffect, Parameter

class Heavier(ModelEffect):
    """A tip that is heavier than its parameter says."""

    id = "heavier"
    needs = frozenset({"boom"})
    table = {"mass": Parameter("kg", 0.0, 0.0, 50.0, 5.0)}
    confused_with = ("tip_payload",)

    def edit(self, spec, machine):
        body = spec.site("tip").parent.add_body(name="more", explicitinertial=True)
        body.mass, body.inertia = 1.0 + self.values["mass"], [1.0, 1.0, 1.0]
'''
    with pytest.raises(EffectError, match="neutral values change no byte"):
        check_effect(load_effects(file(tmp_path, text))["heavier"], machine=BOOM)


def test_commands_take_files_of_effects(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "boom_mj", "simulate", "boom36", "hold", "-o", "hold.mcap"]
    given = ["--effects", str(file(tmp_path)), "--effect", "tip_rope:force=300"]
    done = subprocess.run([*command, *given], capture_output=True, text=True, cwd=tmp_path, timeout=300)
    assert done.returncode == 0, done.stderr
    without = subprocess.run([*command, *given[2:]], capture_output=True, text=True, cwd=tmp_path, timeout=300)
    assert without.returncode == 2 and "no effect 'tip_rope'" in without.stderr
