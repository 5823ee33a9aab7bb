"""Watching a machine: chance alone is no change."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from boom_mj.cli.watch import _summary
from boom_mj.diagnosis.watch import _moment, _state, _windows
from boom_mj.report import draw_watch

GROUP, WHOLE, WINDOWS = "imu/link2/specific_force/x", 20, 7


def squares(last: float, factor: float = 1.0) -> dict[int, np.ndarray]:
    """Three healthy recordings of noise and one that is watched, whose last window has one sample, of size `last`."""
    rng = np.random.default_rng(0)
    count = WHOLE * WINDOWS + 1
    residual = rng.standard_normal((4, count))
    residual[3] *= factor
    residual[3, -1] = last
    data = SimpleNamespace(
        channels=[SimpleNamespace(group=GROUP)],
        spread=lambda here: np.full(4 * count, here[0]),
        used=np.ones(4 * count, bool),
        recording_of=np.repeat(range(4), count),
        recordings=range(4),
        time=np.tile(np.arange(count, dtype=float), 4),
        correlation_s=float(WHOLE),
    )
    return _windows(SimpleNamespace(data=data), residual.ravel(), GROUP)  # type: ignore[arg-type]


def test_one_sample_at_the_end_is_no_change() -> None:
    found = squares(last=5.0)
    assert [np.isfinite(found[k]).sum() for k in range(4)] == [WINDOWS] * 4
    assert not _state("watched", {GROUP: found}, 3, 3, 1.15**2).changed


def test_twice_the_noise_is_a_change() -> None:
    assert _state("watched", {GROUP: squares(last=0.0, factor=2.0)}, 3, 3, 1.15**2).changed


@pytest.mark.parametrize("first", [0, 3, 5])
def test_when_within_a_log(first: int) -> None:
    """Seen in one group where the machine moves, in another where it does not; the rest of a window counts for none."""
    quiet, moving = squares(last=5.0), squares(last=5.0)
    late = np.arange(WINDOWS + 1) >= first
    quiet[3] = np.where(late & (np.arange(WINDOWS + 1) % 2 == 0), 4.0, quiet[3])
    moving[3] = np.where(late & (np.arange(WINDOWS + 1) % 2 == 1), 4.0, moving[3])
    assert _moment({GROUP: quiet, "cylinder2": moving}, 3, 3, 1.15**2, WHOLE) == first * WHOLE


def test_a_change_that_shows_now_and_then_and_one_that_no_window_shows_alone() -> None:
    stops, faint = squares(last=5.0), squares(last=5.0)
    stops[3] = np.where(np.isin(np.arange(WINDOWS + 1), [2, 4]), 4.0, 1.0)
    assert _moment({GROUP: stops}, 3, 3, 1.15**2, WHOLE) == 2 * WHOLE
    faint[3] = np.where(np.arange(WINDOWS + 1) >= 4, 1.9, 1.0)
    assert _moment({GROUP: faint}, 3, 3, 1.15**2, WHOLE) == 4 * WHOLE


def test_sizes_that_time_did_not_suffice_for(tmp_path: Path) -> None:
    size = {"value": 0.75, "low": 0.7, "high": None, "unit": "1"}
    cause = {"id": "link_stiffness", "location": {"link": 3, "axis": "v"}, "parameters": {"factor": size}}
    state = {"changed": True, "statistic": 9.0, "limit": 4.0, "group": GROUP}
    logs = [{"log": "monday", **state, "effects": [cause]}, {"log": "tuesday", **state, "effects": []}]
    answer = {"logs": logs, "since": {"log": "monday", "time_s": 0.0}, "verdict": "explained", "effects": [cause]}
    *_, title, first, second = _summary(answer, "softer").splitlines()
    assert title == "link stiffness (link 3, axis v), factor in each log by itself:"
    assert (first, second) == ("monday  0.75 (0.7 to inf)", "tuesday  not looked at for want of time")
    draw_watch(answer, tmp_path / "watch.png")
    assert (tmp_path / "watch.png").stat().st_size > 1000
