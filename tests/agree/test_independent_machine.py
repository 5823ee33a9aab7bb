"""A log of boom36 built of geometrically exact beams in another engine, replayed."""

from pathlib import Path

import pytest

from boom_mj.logs import read_mcap
from boom_mj.machine import load_machine
from boom_mj.replay import replay
from boom_mj.simulation import make_plant

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def ratios() -> dict[int, dict[str, float]]:
    machine = load_machine(ROOT / "models" / "boom36.toml")
    log = read_mcap(ROOT / "logs" / "independent_release_stretched_vertical.mcap")
    return {n: {g.name: g.ratio for g in replay(make_plant(machine, n), log).groups} for n in (1, 4)}


def test_rates_and_forces_meet_the_noise_floor(ratios: dict[int, dict[str, float]]) -> None:
    """Where joint zero offsets hardly show, four hinges leave little more than noise (1 is noise alone)."""
    for name, ratio in ratios[4].items():
        if "angular_rate" in name:
            assert ratio < 2, name
        if name.startswith("cylinder"):
            assert ratio < 3, name


def test_more_hinges_are_nearer_to_the_machine(ratios: dict[int, dict[str, float]]) -> None:
    for name in ("imu/link5/angular_rate/z", "imu/link4/specific_force/y", "markers/link5/z", "cylinder3"):
        assert ratios[4][name] < ratios[1][name] / 2, name
