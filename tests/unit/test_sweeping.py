"""Sweeps: ranges as points, the same files however the work is spread, and what a begun folder does."""

import csv
import os
import signal
from pathlib import Path

import numpy as np
import pytest

from boom_mj.errors import InputError
from boom_mj.logs import read_mcap
from boom_mj.machine import load_machine, with_values
from boom_mj.simulation import Experiment
from boom_mj.sweeping import Axis, Sweep, run_sweep, simulate_point

BOOM = load_machine(Path(__file__).parents[2] / "models" / "boom36.toml")
DROP = Experiment(
    name="drop", description="a rope is cut", pose_deg=(0,) * 5, duration=1, load=(0, 0, -981), release=0.2
)
AXES = tuple(map(Axis.parse, ("tip_payload:mass=0..100/2", "link3.youngs_modulus_y=0.9e11..1.7e11/2")))
GRID = Sweep(BOOM, DROP, AXES)


def files(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir()}


def test_ranges_are_read_and_wrong_ones_named() -> None:
    assert AXES[0] == Axis("tip_payload", "mass", 0, 100, 2) and str(AXES[0]) == "tip_payload:mass"
    assert Axis.parse("link_mass:link=3,factor=-.5..1e0") == Axis("link_mass:link=3", "factor", -0.5, 1)
    for text in ("mass", "gravity=9", "gravity=9..x/2", "gravity=9..10/0", "gravity=9..inf/2", "=1..2/2"):
        with pytest.raises(InputError, match="a range reads"):
            Axis.parse(text)
    for axes, draws, told in (
        (["gravity=9..10"], None, "say how many"),
        (["gravity=9..10/2"], 3, "has no /2"),
        (["gravity=9..10/2"] * 2, None, "twice"),
        (["link3.weight=1..2/2"], None, "link3 there are .*mass"),
        (["link3=1..2/2"], None, "no number link3"),
        (["name=1..2/2"], None, "it is 'boom36'"),
        (["link3.mass=-1..2/2"], None, "greater than 0"),
        (["tip_payload:mass=0..1e9/2"], None, "outside"),
    ):
        with pytest.raises(InputError, match=told):
            Sweep(BOOM, DROP, tuple(map(Axis.parse, axes)), draws=draws).check()


def test_points_of_a_grid_and_draws_that_can_be_continued() -> None:
    assert [point.values for point in GRID.points()] == [(0, 0.9e11), (0, 1.7e11), (100, 0.9e11), (100, 1.7e11)]
    few, many = (Sweep(BOOM, DROP, (Axis("", "gravity", 9, 10),), draws=n) for n in (3, 200))
    assert list(many.points())[:3] == list(few.points()) and len(many) == 200
    drawn = np.array([point.values for point in many.points()])
    assert drawn.min() > 9 and drawn.max() < 10 and abs(drawn.mean() - 9.5) < 4 * np.sqrt(1 / 12 / 200)


def test_values_go_where_they_belong_and_nowhere_else() -> None:
    sweep = Sweep(BOOM, DROP, tuple(Axis("imu_bias:link=4", name, 0, 0.01) for name in ("gyroscope_x", "gyroscope_y")))
    _, (effect,) = sweep.at((0.001, 0.002))
    assert effect.location == {"link": 4} and effect.values["gyroscope_y"] == 0.002
    changed = with_values(BOOM, {"link3.wall.1": 0.004, "damping.bending": 2.0, "gravity": 9.0})
    assert (changed.links[1].wall, changed.damping.bending, changed.gravity) == (
        (BOOM.links[1].wall[0], 0.004),
        2.0,
        9.0,
    )
    assert with_values(changed, {"link3.wall.1": 0.005, "damping.bending": 0, "gravity": 9.81}) == BOOM


def test_the_files_do_not_depend_on_who_made_them(cluster: str, tmp_path: Path) -> None:
    """One process; a cluster of which a worker is killed; and a folder from which points are missing."""
    one, other = tmp_path / "one", tmp_path / "other"
    assert list(run_sweep(GRID, one)) == [(k, None) for k in range(5)]
    whole = files(one)
    assert len(whole) == 4 + 4 + 2
    from distributed import Client

    for done, error in run_sweep(GRID, other, cluster=cluster):
        assert error is None
        if done == 1:
            with Client(cluster, set_as_default=False) as client:
                os.kill(next(iter(client.run(os.getpid).values())), signal.SIGKILL)
    assert files(other) == whole
    (one / "000002.json").unlink()
    (one / "table.csv").unlink()
    kept = (one / "000001.mcap").stat().st_mtime_ns
    assert list(run_sweep(GRID, one, jobs=2)) == [(3, None), (4, None)]
    assert files(one) == whole and (one / "000001.mcap").stat().st_mtime_ns == kept
    rows = list(csv.DictReader((one / "table.csv").open()))
    assert [row["recording"] for row in rows] == [f"{k:06d}.mcap" for k in range(4)]
    height = [float(row["tip_start_z"]) for row in rows]
    assert height[2] < height[0] < height[1] > height[3]  # a payload pulls down, a stiffer link holds up
    log = read_mcap(one / rows[3]["recording"])
    assert log.description == "a rope is cut; tip_payload:mass = 100; link3.youngs_modulus_y = 1.7e+11"
    for wanted, told in ((Sweep(BOOM, DROP, AXES, seed=1), "differs in seed"), (GRID, "not a JSON file")):
        with pytest.raises(InputError, match=told):
            list(run_sweep(wanted, one))
        (one / "sweep.json").write_text("torn")


def test_a_point_that_cannot_be_simulated_is_a_row_with_its_error(tmp_path: Path) -> None:
    both = tuple(map(Axis.parse, ("link3.wall.0=0.005..0.17/2", "link3.height.0=0.3..0.44/2")))
    sweep = Sweep(BOOM, DROP, both)
    sweep.check()
    thick, high = list(sweep.points())[2:]
    assert "half the box" in simulate_point(thick, sweep, tmp_path)["error"] and not list(tmp_path.iterdir())
    assert simulate_point(high, sweep, tmp_path)["recording"] == "000003.mcap" and list(tmp_path.iterdir())
