"""Machines that exist, measured by others: what is named agrees with what is known of them another way.

The data are no part of the project: `BOOM_MJ_REAL`, or ../shared/real beside it, is where they lie. Machines whose
diagnosis takes minutes are asked by `scripts/real_machines.py`.
"""

import os
import sys
from pathlib import Path

import pytest

from boom_mj.systems.mjcf import load_channel_map, load_mjcf
from boom_mj.systems.predictor import Predictor

ROOT = Path(__file__).parents[2]
sys.path.append(str(ROOT / "scripts"))

from real_machines import MACHINES, RealMachine, row  # noqa: E402 - once the path is known

REAL = Path(os.environ.get("BOOM_MJ_REAL", ROOT.parent / "shared" / "real"))
TWO_LINKS = RealMachine("two_link_arm", ("two_link_arm/lqr_full_10deg.mat",), (), "friction of both hubs", lambda _: {})


def of(machines: list[RealMachine]) -> pytest.MarkDecorator:
    return pytest.mark.parametrize("machine", machines, ids=lambda machine: machine.name)


def there(machine: RealMachine) -> None:
    if missing := machine.missing(REAL):
        pytest.skip(f"{missing} not at {REAL}; BOOM_MJ_REAL says where recordings of real machines are")


@of([*MACHINES, TWO_LINKS])
def test_maps_fit_their_models_and_logs(machine: RealMachine) -> None:
    """Every set is simulated from its nominal model; its gap is there to be explained."""
    there(machine)
    given = load_mjcf([REAL / machine.train[0]], [], machine.map)
    system, data = given.system, given.data
    (nominal,) = Predictor(system, data).predict([()], system.facts.fidelity.middle, data.trained)
    misses = ((data.measured - nominal) / data.noise)[data.train]
    assert 1 < float((misses**2).mean() ** 0.5) < 1e3
    assert {channel.signal for channel in data.channels} == {
        entry.name for entry in load_channel_map(machine.map).role("compare")
    }


@pytest.mark.slow
@of([machine for machine in MACHINES if machine.quick])
def test_what_is_named_agrees_with_what_is_known(machine: RealMachine) -> None:
    there(machine)
    answer = machine.answer(REAL)
    asked = machine.checks(answer)
    assert all(asked.values()), (asked, answer["sentence"])
    assert machine.known in row(machine, {"answer": answer, "cpu_s": 0.0, "commit": ""})
