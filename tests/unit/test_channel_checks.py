"""What checks of data compute of a channel, by numbers worked out by hand."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.stats import norm

from boom_mj.replay.quality.assessment import ChannelQuality, Quality, SignalQuality, quiet_noise
from boom_mj.replay.quality.beside import Pair, by_case, concerned
from boom_mj.replay.quality.channels import CHANCE, limits, own_noise, resolution, runs, shortest_run
from boom_mj.replay.quality.edits import DRIVE
from boom_mj.replay.quality.evidence import sensor_of, spans
from boom_mj.replay.quality.kinds import clock
from boom_mj.replay.quality.kinds.clock import _earlier, _slower, _without_leap
from boom_mj.replay.quality.kinds.frozen import _delayed, _lag, _range
from boom_mj.replay.quality.kinds.spiky import TOGETHER, _blows, _cubic, outliers

NOISE = np.random.default_rng(0).standard_normal(4000)


def test_runs_are_of_equal_neighbours_and_long_enough() -> None:
    values = np.array([1.0, 1.0, 1.0, 2.0, 3.0, 3.0, 4.0, 5.0, 5.0, 5.0, 5.0])
    assert runs(values, 2) == [(0, 3), (4, 6), (7, 11)]
    assert runs(values, 3) == [(0, 3), (7, 11)]
    assert runs(values, 5) == [] and runs(np.arange(4.0), 2) == []


def test_stretches_begin_and_end_where_what_is_bad_does() -> None:
    assert list(spans(np.array([True, False, True, True, False]))) == [(0, 1), (2, 4)]
    assert list(spans(np.array([False, True]))) == [(1, 2)] and not list(spans(np.zeros(3, bool)))


def test_a_resolution_is_the_smallest_step_but_for_rounding() -> None:
    assert resolution(0.25 * np.array([4.0, 1.0, np.nan, 2.0, 9.0])) == 0.25
    assert resolution(np.array([1.0, 1.0 + 1e-12, 1.5])) == pytest.approx(0.5)
    assert resolution(np.array([-3.0, -3.0 - 2e-9, -2.0])) == pytest.approx(1.0)
    assert resolution(np.array([3.0, np.nan])) == 0.0 and resolution(np.array([])) == 0.0


def test_noise_of_a_channel_is_that_of_its_known_samples() -> None:
    assert own_noise(np.where(np.arange(4000) % 7, 0.3 * NOISE + 5, np.nan)) == pytest.approx(0.3, rel=0.05)
    assert own_noise(np.array([1.0, 2.0])) == 0.0 and own_noise(np.array([1.0, 2.0, 1.0])) > 0.0


@pytest.mark.parametrize("step", [0.1, 1.0, 6.0])
def test_a_run_is_so_long_that_chance_does_not_make_it(step: float) -> None:
    alike = norm.cdf(step / 2) - norm.cdf(-step / 2)  # a sample on the step of the one before, at best
    needed = shortest_run(step, 1.0)
    assert needed == 10 or alike**needed <= CHANCE < alike ** (needed - 1)
    assert (needed == 10) == (step == 0.1) and shortest_run(2 * step, 2.0) == needed


def test_without_noise_ten_samples_are_a_run_and_in_steps_far_above_it_none_is() -> None:
    assert shortest_run(1.0, 0.0) == 10 and shortest_run(100.0, 1.0) == 10**9


def test_samples_pile_up_on_the_limits_of_a_converter() -> None:
    assert limits(NOISE, 1.0) == []
    assert limits(np.clip(NOISE, -np.inf, 1.5), 1.0) == [1.5]
    assert limits(np.clip(NOISE, -1.0, np.inf), 1.0) == [-1.0]
    assert limits(np.clip(np.r_[NOISE, np.nan], -1.0, 1.5), 1.0) == [-1.0, 1.5]
    assert limits(np.clip(np.round(NOISE), -1, 1), 1.0) == []  # a coarse channel has few levels, all of them high
    tail = np.sort(NOISE)[::-1]
    seven, eight = (np.clip(NOISE, -np.inf, tail[k]) for k in (6, 7))
    assert limits(seven, 1.0) == [] and limits(eight, 1.0) == [tail[7]]


def test_a_limit_stands_out_of_the_steps_beside_it() -> None:
    fine = np.repeat(np.arange(30) / 10, 10)  # ten samples a step
    assert limits(fine, 0.5) == []
    assert limits(np.r_[fine, np.full(39, 2.9)], 0.5) == [] and limits(np.r_[fine, np.full(40, 2.9)], 0.5) == [2.9]


def test_sensors_of_one_box_are_one() -> None:
    names = ("imu/link3/specific_force", "imu/link3/angular_velocity", "joint_command/position", "joint/position")
    assert [sensor_of(name) for name in names] == ["imu/link3", "imu/link3", "joint_command", "joint/position"]


def test_a_fault_is_of_the_recordings_that_show_it_and_of_those_that_tell_nothing_unless_one_lacks_it() -> None:
    assert concerned({0: 11.0, 1: 1.0}, (0, 1, 2)) == (0, 1, 2)
    assert concerned({0: 11.0, 1: 0.09}, (0, 1, 2)) == (0,)
    assert concerned({0: 11.0, 1: 0.11}, (0, 1)) == (0, 1)
    assert concerned({0: 9.0, 1: 1.0}, (0, 1)) == () and concerned({0: 9.0}, (0,), clear=8.0) == (0,)


def test_numbers_by_recording_are_numbers_by_case() -> None:
    assert by_case({0: {"a": 1.0, "b": 2.0}, 3: {"a": 4.0}}) == {"a": {0: 1.0, 3: 4.0}, "b": {0: 2.0}}


@pytest.mark.parametrize("rests", [True, False])
@pytest.mark.parametrize("late", [0.06, -0.04])
def test_joints_are_behind_their_commands_by_a_lag_whatever_their_zero(
    late: float, rests: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    time = np.arange(0, 20, 0.02)
    moving = np.clip(time - 8, 0, 4) if rests else time

    def angle(at: np.ndarray) -> np.ndarray:
        return 0.2 * np.interp(at, time, moving)[:, None] + np.zeros(5)

    joints = SimpleNamespace(time=time, values=angle(time - late) + (0.01 if rests else 0.0))
    evidence = SimpleNamespace(recordings=[{DRIVE: joints}])
    monkeypatch.setattr(clock, "expected", lambda *given: angle(time))
    if rests:
        assert clock._behind(evidence, 0) == pytest.approx(late, abs=0.002)  # type: ignore[arg-type]
    else:  # an even motion's lag is an offset
        assert clock._behind(evidence, 0) == pytest.approx(0, abs=0.002)  # type: ignore[arg-type]
    monkeypatch.setattr(clock, "expected", lambda *given: angle(0 * time))
    assert clock._behind(evidence, 0) is None  # type: ignore[arg-type]


def test_a_pair_compares_as_it_is_turned_round_and_about_its_means() -> None:
    pair = Pair(np.array([[1.0], [np.nan], [5.0]]), np.array([[-1.0], [0.0], [-2.0]]))
    assert pair.power == pytest.approx([5 / 3])
    assert pair.misfit() == pytest.approx([(4 + 49) / 2]) and pair.misfit(-1) == pytest.approx([(0 + 9) / 2])
    assert pair.moving.measured[:, 0] == pytest.approx([-2.0, np.nan, 2.0], nan_ok=True)
    assert pair.moving.expected[:, 0] == pytest.approx([0.0, 1.0, -1.0])


def test_noise_is_that_of_the_quieter_half() -> None:
    time = np.arange(4000) * 0.01
    loud = np.where(time < 18.0, 5.0, 1.0) * NOISE
    assert quiet_noise(time, loud) == pytest.approx(1.0, rel=0.1)
    assert quiet_noise(time[:5], np.array([0.0, 1.0, 0.0, np.nan, 1.0])) > 0.3


def channel(name: str, ratio: float, excitation: float = 1.0) -> ChannelQuality:
    return ChannelQuality(name, 0.1 * ratio, 0.1, excitation)


def signal(name: str, *channels: ChannelQuality, **fields: float) -> SignalQuality:
    usual = {"rate_hz": 50.0, "samples_per_period": 20.0, "missing": 0.0, "longest_gap": 0.02, "longest_gap_at": 3.0}
    return SignalQuality(name, **{**usual, **fields}, channels=channels)


def test_remarks_say_what_and_how_much() -> None:
    assert list(signal("markers", channel("a", 1.49), channel("b", 0.51)).remarks()) == []
    assert list(signal("markers", missing=0.01, longest_gap=0.1, samples_per_period=8.0).remarks()) == []
    assert list(signal("markers", missing=0.111).remarks()) == ["11 % of markers are missing"]
    assert list(signal("markers", longest_gap=0.12).remarks()) == ["markers has a gap of 0.12 s at 3.00 s"]
    (slow,) = signal("markers", samples_per_period=4.0).remarks()
    assert slow == ("markers at 50.0 Hz has 4.0 samples in a period of the boom's first 4 modes; 8 are needed, 100 Hz")
    (loud,) = signal("markers", channel("a", 2.0), channel("b", 1.0), channel("c", 3.0)).remarks()
    assert loud == "markers a, c scatters more than the machine file says: 2 to 3 x its noise"
    (quiet,) = signal("markers", *(channel(f"c{k}", 0.25) for k in range(6))).remarks()
    assert quiet == (
        "markers c0, c1, c2, c3 and 2 more scatters less than the machine file says: 0.25 to 0.25 x its noise"
    )
    (five,) = signal("markers", *(channel(f"c{k}", 0.25) for k in range(5))).remarks()
    assert "c0, c1, c2, c3, c4 scatters" in five
    assert ChannelQuality("a", 0.1, 0.0, 0.0).noise_ratio == np.inf


def test_a_summary_counts_what_moves() -> None:
    joints = signal("joint/position", channel("joint1", 1.0, 0.4), channel("joint2", 1.0, 0.6))
    others = signal("markers", channel("a", 1.0, 0.4), channel("b", 1.0, 2.0), samples_per_period=9.5)
    quality = Quality((0.42, 0.51), (joints, others))
    assert quality.summary() == (
        "moving: joint2, 1 of 2 other channels; modes 0.42, 0.51 Hz, 9.5 samples or more in the shortest period"
    )
    assert quality.remarks() == ()
    still = Quality((0.42,), (signal("joint/position", channel("joint1", 1.0, 0.4)),))
    assert still.summary().startswith("moving: no joint, 0 of 0") and "boom at rest" in still.remarks()[0]


def test_a_cubic_through_its_neighbours_says_what_a_sample_should_be() -> None:
    time = np.arange(9.0)
    cube = 2 - time + 0.5 * time**2 - 0.1 * time**3
    assert _cubic(cube) == pytest.approx(cube)
    cube[4] += 6.0
    assert (_cubic(cube) - cube)[2:7] == pytest.approx([-1.0, 4.0, -6.0, 4.0, -1.0])


def test_outliers_are_beyond_noise_and_beyond_what_is_usual_around() -> None:
    values = 0.1 * NOISE + np.sin(0.01 * np.arange(4000))
    values[[500, 503, 900]] += [3.0, -2.0, 1.6]
    values[1300] += 0.5  # five deviations
    values[2000] = np.nan
    assert np.flatnonzero(outliers(values, 0.1)).tolist() == [500, 503, 900]
    lively = values + 3.0 * (np.arange(4000) % 2)  # which jumps at every sample
    assert np.flatnonzero(outliers(lively, 0.1)).tolist() == []
    assert not outliers(values[:50], 0.1).any() and not outliers(values, 0.0).any()


def test_what_two_sensors_see_at_once_is_a_blow() -> None:
    near, far = 0.9 * TOGETHER, 1.1 * TOGETHER
    seen = {"imu/link3/specific_force": np.array([1.0, 2.0]), "imu/link3/angular_velocity": np.array([5.0])}
    others = {"markers": np.array([1.0 + near, 2.0 + far, 5.0 - near])}
    assert sorted(_blows({**seen, **others})) == pytest.approx([1.0, 1.0 + near, 5.0 - near, 5.0])
    assert _blows(seen).size == 0  # one box


def test_clocks_are_turned_back() -> None:
    time = np.array([1.0, 2.0, 3.5, 4.5])
    assert _without_leap(2.0, 0.5, time) == pytest.approx([1.0, 2.0, 3.0, 4.0])
    assert _slower(1.25, time) == pytest.approx([1.0, 1.8, 3.0, 3.8]) and _earlier(0.5, time) == pytest.approx(
        time - 0.5
    )


def delayed(lag: float, level: float) -> SimpleNamespace:
    """Ten channels that a model predicts, delayed, with noise of a level."""
    time = np.arange(4000) / 100

    def predicted(index: int, name: str, by: float = 0.0) -> np.ndarray:
        return np.sin(2.0 * (time - by))[:, None] * np.ones(10)

    noise = level * np.random.default_rng(1).standard_normal((4000, 10))
    return SimpleNamespace(
        recordings=[
            {
                "markers": SimpleNamespace(time=time, values=predicted(0, "", lag) + noise),
                DRIVE: SimpleNamespace(time=time),
            }
        ],
        measured=lambda index: ["markers"],
        predicted=predicted,
        noise=lambda name: np.full(10, level),
    )


@pytest.mark.parametrize("lag", [-0.3, -0.05, -0.025, 0.2])
def test_a_stream_precedes_its_model_by_a_lag(lag: float) -> None:
    assert clock._lag(delayed(lag, 0.01), 0, "markers") == pytest.approx(lag, abs=0.005)


@pytest.mark.parametrize(("lag", "level"), [(0.0, 0.01), (-0.3, 1e3)], ids=["in time", "nothing but noise"])
def test_a_lag_that_fits_no_better_than_none_is_none(lag: float, level: float) -> None:
    assert clock._lag(delayed(lag, level), 0, "markers") is None


def test_commands_are_delayed_by_as_many_rows_as_fit_best() -> None:
    commands = np.cumsum(np.c_[NOISE[:50], NOISE[50:100]], axis=0)
    late = _delayed(commands, 3)
    assert late[3:] == pytest.approx(commands[:-3]) and late[:3] == pytest.approx(np.tile(commands[0], (3, 1)))
    late[10] = np.nan
    assert _lag(late, commands, 5) == 3 and _lag(late, commands, 2) == 2 and _lag(commands, commands, 5) == 0
    assert _range(np.array([0.0, 2.0, 1.0, 1.0, -1.0]), 3) == pytest.approx([2.0, 2.0, 1.0, 2.0, 2.0])
