"""Watching a machine: chance alone is no change."""

from types import SimpleNamespace

import numpy as np

from boom_mj.diagnosis.watch import _state, _windows

GROUP, WHOLE, WINDOWS = "imu/link2/specific_force/x", 20, 7


def squares(last: float, factor: float = 1.0) -> dict[int, np.ndarray]:
    """Three healthy recordings of noise and one that is watched, whose last window has one sample, of size `last`."""
    rng = np.random.default_rng(0)
    count = WHOLE * WINDOWS + 1
    residual = rng.standard_normal((4, count))
    residual[3] *= factor
    residual[3, -1] = last
    windows = np.concatenate([np.arange(count) // WHOLE + 100 * k for k in range(4)])
    data = SimpleNamespace(
        channels=[SimpleNamespace(group=GROUP)],
        spread=lambda here: np.full(4 * count, here[0]),
        used=np.ones(4 * count, bool),
        recording_of=np.repeat(range(4), count),
        recordings=range(4),
        windows=windows,
    )
    return _windows(SimpleNamespace(data=data), residual.ravel(), GROUP)  # type: ignore[arg-type]


def test_one_sample_at_the_end_is_no_change() -> None:
    found = squares(last=5.0)
    assert [len(found[k]) for k in range(4)] == [WINDOWS] * 4
    assert not _state("watched", {GROUP: found}, 3, 3, 1.15**2).changed


def test_twice_the_noise_is_a_change() -> None:
    assert _state("watched", {GROUP: squares(last=0.0, factor=2.0)}, 3, 3, 1.15**2).changed
