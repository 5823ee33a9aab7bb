"""`logs check`: sentences, exit statuses, and topic maps by which a spoiled log reads well."""

import json
import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from boom_mj.cli import run
from boom_mj.errors import LogError, LogWarning
from boom_mj.logs import load_topic_map, read_log, write_mcap
from boom_mj.logs.order import in_order
from boom_mj.machine import load_machine
from boom_mj.recording import Recording
from boom_mj.sensors import record
from boom_mj.simulation import CATALOGUE, make_plant, run_experiment


@pytest.fixture(scope="module")
def sound() -> list[Recording]:
    plant, rng = make_plant(load_machine("boom36"), 1), np.random.default_rng(0)
    names = ("release_bow_vertical", "mixed")
    return [record(run_experiment(plant, CATALOGUE[n]), CATALOGUE[n], rng) for n in names]


def spoiled(log: Recording) -> Recording:
    """Two IMUs swapped, joint 1 in degrees, forces in kN, markers 4 and 9 swapped, an axis and a joint turned."""
    imus = {
        f"imu/link{a}/{q}": replace(log[f"imu/link{b}/{q}"], frame=log[f"imu/link{a}/{q}"].frame)
        for a, b in ((3, 4), (4, 3))
        for q in ("specific_force", "angular_rate")
    }
    order = [*range(9), *range(24, 27), *range(12, 24), *range(9, 12), *range(27, 36)]
    joints, force, markers = log["joint/position"], log["cylinder/force"], log["markers"]
    axis = log["imu/link2/specific_force"]
    return log.with_signals(
        {
            **imus,
            "joint/position": replace(joints, values=joints.values * [180 / np.pi, 1, 1, -1, 1] + [0, 0, 0.05, 0, 0]),
            "cylinder/force": replace(force, values=force.values / 1000),
            "markers": replace(markers, values=markers.values[:, order]),
            "imu/link2/specific_force": replace(axis, values=axis.values * [1, -1, 1]),
        }
    )


def written(logs: list[Recording], folder: Path) -> list[str]:
    for log in logs:
        write_mcap(log, folder / f"{log.name}.mcap")
    return [str(folder / f"{log.name}.mcap") for log in logs]


def test_a_map_mends_what_a_map_can(sound: list[Recording], tmp_path: Path, capsys: pytest.CaptureFixture) -> None:
    first, second = written([spoiled(log) for log in sound], tmp_path)
    fix = tmp_path / "map.toml"
    assert run(["logs", "check", first, "--holdout", second, "--fix", str(fix)]) == 1
    out = capsys.readouterr().out
    assert "cylinder/force/cylinder2 is 0.001" in out and 'unit = "kN"' in out and "imu/link3 does not fit" in out
    assert run(["logs", "check", first, "--holdout", second, "--map", str(fix)]) == 0
    assert "nothing found" in capsys.readouterr().out
    mended = read_log(first, load_topic_map(fix))
    for name in ("imu/link3/angular_rate", "cylinder/force", "markers", "imu/link2/specific_force"):
        assert np.allclose(mended[name].values, sound[0][name].values, rtol=1e-12), name
    assert np.allclose(mended["joint/position"].values, sound[0]["joint/position"].values, atol=1e-3)


def test_logs_that_differ_get_maps_of_their_own(sound: list[Recording], tmp_path: Path) -> None:
    force = sound[1]["cylinder/force"]
    odd = sound[1].with_signals({"cylinder/force": replace(force, values=force.values[:, ::-1])})
    first, second = written([spoiled(sound[0]), odd], tmp_path)
    assert run(["logs", "check", first, second, "--fix", str(tmp_path / "map.toml")]) == 1
    assert run(["logs", "check", first, "--map", str(tmp_path / "map.toml")]) == 0
    assert run(["logs", "check", second, "--map", str(tmp_path / "map-2.toml")]) == 0


def test_findings_as_json_and_exit_statuses(
    sound: list[Recording], tmp_path: Path, capsys: pytest.CaptureFixture
) -> None:
    first, second = written(sound, tmp_path)
    assert run(["logs", "check", first, "--holdout", second, "--json", "-"]) == 0
    assert json.loads(capsys.readouterr().out) == {"data": []}
    assert run(["logs", "check", first, "--holdout", first, "--json", str(tmp_path / "f.json")]) == 1
    (finding,) = json.loads((tmp_path / "f.json").read_text())["data"]
    assert finding["kind"] == "copy" and finding["action"] == "refused" and finding["used"] is False
    assert run(["logs", "check", str(tmp_path / "none.mcap")]) == 2
    assert run(["logs", "check", first, "--machine", "no_such_machine"]) == 2
    assert run(["logs", "check", first, "--fix", str(tmp_path / "map.txt")]) == 2


def test_messages_recorded_late_are_sorted_by_their_stamps() -> None:
    stamps = np.arange(1000) * 20_000_000
    order = np.arange(1000, dtype=float)
    order[::100] += 25.5  # recorded half a second later
    recorded = np.argsort(order, kind="stable")
    with pytest.warns(LogWarning, match=r"put in their place"):
        back, values = in_order(stamps[recorded], recorded[:, None].astype(float), "/imu/link3")
    assert np.array_equal(back, stamps) and np.array_equal(values[:, 0], np.arange(1000))


@pytest.mark.parametrize("shift", [5e8, 0.43e9, 0.011e9 + 2e8])
def test_a_clock_set_back_is_still_refused(shift: float) -> None:
    stamps = np.arange(1000) * 20_000_000
    stamps[970:] -= int(shift)
    with pytest.raises(LogError, match=r"set back|must increase"):
        in_order(stamps, np.arange(1000.0)[:, None], "/imu/link3")


def test_one_warning_a_log(sound: list[Recording], tmp_path: Path) -> None:
    slow = {}
    for name in ("joint/position", "joint_command/position", "joint_command/velocity"):
        signal = sound[0][name]
        keep = (np.arange(len(signal.time)) % 5 == 0) & ((signal.time < 10) | (signal.time > 10.85))
        slow[name] = replace(signal, time=signal.time[keep], values=signal.values[keep])
    write_mcap(sound[0].with_signals(slow), tmp_path / "slow.mcap")
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        read_log(tmp_path / "slow.mcap")
    (warning,) = [w for w in told if issubclass(w.category, LogWarning)]
    assert "1 holes of up to" in str(warning.message) and "joint angles at 10.0 Hz" in str(warning.message)
