"""A log is judged before it drives a model: every flaw that is planted is named, and a good log has none."""

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from boom_mj.errors import LogError
from boom_mj.logs import read_log
from boom_mj.machine import load_machine
from boom_mj.recording import Recording, Signal
from boom_mj.replay.quality import Quality, assess
from boom_mj.simulation import make_plant

ROOT = Path(__file__).parents[2]
PLANT = make_plant(load_machine(ROOT / "models" / "boom36.toml"), 1)


@cache
def release() -> Recording:
    return read_log(ROOT / "logs" / "independent_release_stretched_vertical.mcap")


def changed(name: str, **fields: object) -> Quality:
    log = release()
    return assess(PLANT, replace(log, signals={**log.signals, name: replace(log[name], **fields)}))


def only_remark(quality: Quality) -> str:
    (remark,) = quality.remarks()
    return remark


def channels(quality: Quality, name: str) -> dict:
    return {c.name: c for signal in quality.signals if signal.name == name for c in signal.channels}


def test_a_good_log() -> None:
    quality = assess(PLANT, release())
    assert quality.remarks() == ()
    assert quality.modes_hz[:2] == pytest.approx((0.42, 0.51), abs=0.02)
    assert not any(c.moves for c in channels(quality, "joint/position").values())
    assert channels(quality, "cylinder/force")["cylinder2"].moves  # the rope is cut
    assert channels(quality, "imu/link5/specific_force")["y"].moves
    assert not channels(quality, "imu/link2/specific_force")["z"].moves  # nothing swings sideways
    for signal in quality.signals:  # a median of 300 samples scatters by a tenth
        assert all(0.65 < c.noise_ratio < 1.35 for c in signal.channels), signal.name


def test_noise_is_told_from_motion() -> None:
    rng, time = np.random.default_rng(0), np.arange(0, 60, 0.02)
    noise = PLANT.machine.sensors.noise.accelerometer
    swing = np.exp(-0.1 * time)[:, None] * np.sin(2 * np.pi * np.outer(time, (0.5, 1.8, 0.5)))
    read = swing * (0, 2.0, 0.5 * noise) + noise * rng.normal(size=swing.shape)
    found = channels(changed("imu/link5/specific_force", time=time, values=read), "imu/link5/specific_force")
    assert [c.moves for c in found.values()] == [False, True, False]
    assert [c.noise_ratio for c in found.values()] == pytest.approx([1, 1, 1], abs=0.15)
    assert found["y"].excitation == pytest.approx(np.std(swing[:, 1] * 2.0) / noise, rel=0.1)


@pytest.mark.parametrize(("factor", "word"), [(3.0, "more"), (0.2, "less")])
def test_noise_unlike_the_machine_file(factor: float, word: str) -> None:
    joints = release()["joint/position"]
    read = joints.values.copy()
    read[:, 2] = read[:, 2].mean() + factor * (read[:, 2] - read[:, 2].mean())
    remark = only_remark(changed("joint/position", values=read))
    assert "joint3" in remark and word in remark and "joint2" not in remark


def test_too_slow_for_the_first_modes() -> None:
    joints = release()["joint/position"]
    time = np.arange(0, 30, 1 / 15)
    slow = np.stack([np.interp(time, joints.time, column) for column in joints.values.T], axis=1)
    noisy = slow + np.radians(0.01) * np.random.default_rng(0).normal(size=slow.shape)
    remark = only_remark(changed("joint/position", time=time, values=noisy))
    assert "joint/position at 15.0 Hz" in remark and "15 Hz" in remark and "7.8" in remark


def test_holes() -> None:
    force = release()["cylinder/force"]
    values = force.values.copy()
    values[100:400, 1] = np.nan
    assert "10 % of cylinder/force" in only_remark(changed("cylinder/force", values=values))
    kept = (force.time < 10) | (force.time > 11)
    remark = only_remark(changed("cylinder/force", time=force.time[kept], values=force.values[kept]))
    assert "gap of 1.0" in remark and "at 9.98 s" in remark


def test_nothing_moves() -> None:
    log, rng = release(), np.random.default_rng(0)
    still: dict[str, Signal] = {}
    for signal in assess(PLANT, log).signals:
        levels = [c.expected_noise for c in signal.channels]
        found = log[signal.name]
        still[signal.name] = replace(found, values=found.values[0] + levels * rng.normal(size=found.values.shape))
    assert "no channel moves" in only_remark(assess(PLANT, replace(log, signals=still)))


def test_no_angles() -> None:
    joints = release()["joint/position"]
    with pytest.raises(LogError, match="no time at which"):
        changed("joint/position", values=np.full_like(joints.values, np.nan))


def test_a_channel_without_samples() -> None:
    markers = release()["markers"]
    values = markers.values.copy()
    values[:, :3] = np.nan
    quality = changed("markers", values=values)
    assert "8 % of markers" in only_remark(quality)
    assert np.isnan(channels(quality, "markers")["marker1/x"].noise)
