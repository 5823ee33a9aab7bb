"""A law that a person wrote into a file acts as it says."""

from pathlib import Path

import numpy as np
import pytest

from boom_mj.effects import BOOM_SITES, load_effects
from boom_mj.errors import EffectError
from boom_mj.machine import load_machine
from boom_mj.recording import Signal
from boom_mj.testing import check_effect

pytestmark = pytest.mark.usefixtures("own_files")

LAW = '''"""A law by hand."""

from boom_mj.effects import Parameter
from boom_mj.effects.laws import CylinderLaw, direction


class LoadFriction(CylinderLaw):
    """Friction in proportion to the load."""

    id = "{name}"
    table = {{"mu": Parameter("1", 0.0, -1.0, 1.0, 0.05)}}

    def law(self, position, speed, load, angle, time, mu):
        return mu * abs(load) * direction(speed, 2e-4)
'''

CYLINDER = next(site for site in BOOM_SITES if site.location == {"cylinder": 2})


def test_a_law_of_a_file_acts(tmp_path: Path) -> None:
    file = tmp_path / "rubbing.py"
    file.write_text(LAW.format(name="rubbing"))
    kind = load_effects(file)["rubbing"]
    check_effect(kind)
    machine, time = load_machine("boom36"), np.arange(0.0, 10.0, 0.01)
    joints = np.zeros((len(time), 5))
    joints[:, 1] = 0.8 + 0.1 * np.sin(time)
    signals = {
        "joint/position": Signal(time, joints, tuple("12345"), "rad", ""),
        "cylinder/force": Signal(time, np.full((len(time), 2), -2e5), ("2", "3"), "N", ""),
    }
    added = kind(CYLINDER, mu=0.05).observe(signals, machine)["cylinder/force"].values - -2e5
    moving = np.abs(np.cos(time)) > 0.2
    assert np.allclose(np.abs(added[moving, 0]), 0.05 * 2e5, rtol=1e-6) and not added[:, 1].any()
    assert kind(CYLINDER).observe(signals, machine) == {}


def test_a_law_must_be_named_as_no_other(tmp_path: Path) -> None:
    file = tmp_path / "taken.py"
    file.write_text(LAW.format(name="pressure_scale"))
    with pytest.raises(EffectError, match="two effects are called pressure_scale"):
        load_effects(file)
