"""Signals and recordings: what they refuse, and the exactness of resampling, windows, common times and spectra."""

import pickle
from dataclasses import replace

import numpy as np
import pytest

from boom_mj.errors import LogError
from boom_mj.recording import (
    QUANTITIES,
    Recording,
    Signal,
    align,
    named_signal,
    point_channels,
    resample,
    spectrum,
    window,
)


def ramp(stop: float = 1.0, rate: float = 10.0, slope: float = 3.0) -> Signal:
    time = np.arange(round(stop * rate) + 1) / rate
    return Signal(time, np.column_stack([slope * time, 1 - time]), ("a", "b"), "m", "world")


def test_a_signal_cannot_be_changed_nor_through_the_arrays_it_was_made_of():
    time, values = np.array([0.0, 1.0]), np.array([[1.0], [2.0]])
    signal = Signal(time, values, ("a",), "m", "world")
    values[0] = 7.0
    assert signal.values[0, 0] == 1.0
    with pytest.raises(ValueError):
        signal.values[0, 0] = 7.0
    with pytest.raises(ValueError):
        signal.time[0] = 7.0


@pytest.mark.parametrize(
    ("time", "values", "channels", "says"),
    [
        ([0.0, 1.0], [[1.0], [2.0], [3.0]], ("a",), "values"),
        ([0.0, 1.0], [[1.0], [2.0]], ("a", "b"), "a, b"),
        ([], np.zeros((0, 1)), ("a",), "n > 0"),
        ([0.0], np.zeros((1, 0)), (), "values"),
        ([0.0], [[1.0, 2.0]], ("a", "a"), "different names"),
        ([0.0, 2.0, 2.0], [[1.0]] * 3, ("a",), "2.000000000 s is followed by 2.0"),
        ([0.0, 2.0, 1.0], [[1.0]] * 3, ("a",), "2.000000000 s is followed by 1.0"),
        ([0.0, np.nan], [[1.0]] * 2, ("a",), "sample 1"),
        ([0.0, 4.0], [[1.0, 1.0], [1.0, np.inf]], ("a", "b"), "b is infinite at 4.000 s"),
    ],
)
def test_a_malformed_signal_is_refused_by_name(time, values, channels, says):
    with pytest.raises(LogError, match=says.replace("(", r"\(")):
        Signal(np.array(time), np.array(values), channels, "m", "world")


def test_resampling_is_exact_on_straight_lines_and_keeps_unit_frame_and_channels():
    time = np.array([0.0, 0.033, 0.5, 1.0])
    found = resample(ramp(), time)
    np.testing.assert_allclose(found.values, np.column_stack([3 * time, 1 - time]), atol=1e-15)  # rounding only
    assert (found.unit, found.frame, found.channels) == ("m", "world", ("a", "b"))


@pytest.mark.parametrize("time", [[-0.1, 0.5], [0.5, 1.1]])
def test_resampling_never_extrapolates(time):
    with pytest.raises(LogError, match=r"a\.\.b .*from 0\.000 to 1\.000 s"):
        resample(ramp(), np.array(time))


def test_a_hidden_sample_stays_hidden_and_its_neighbours_stay_visible():
    signal = Signal(np.arange(4.0), np.array([[0.0], [np.nan], [2.0], [3.0]]), ("a",), "m", "world")
    found = resample(signal, np.array([0.0, 0.5, 1.0, 1.5, 2.0, 2.5])).values[:, 0]
    np.testing.assert_array_equal(found, [0.0, np.nan, np.nan, np.nan, 2.0, 2.5])


def test_a_window_holds_both_its_ends_and_is_never_empty():
    np.testing.assert_array_equal(window(ramp(), 0.2, 0.5).time, [0.2, 0.3, 0.4, 0.5])
    with pytest.raises(LogError, match=r"no sample from 0\.210 to 0\.290 s"):
        window(ramp(), 0.21, 0.29)


def test_aligned_signals_share_the_coarser_times_of_the_common_interval():
    fine = ramp(stop=1.0, rate=100)
    coarse = replace(ramp(stop=2.0, rate=10), time=ramp(stop=2.0, rate=10).time + 0.35)
    for a, b in (align(fine, coarse), align(coarse, fine)[::-1]):
        np.testing.assert_allclose(a.time, np.arange(0.35, 1.0, 0.1), atol=1e-12)
        np.testing.assert_array_equal(a.time, b.time)
        np.testing.assert_allclose(a.values[:, 0], 3 * a.time, atol=1e-12)
        np.testing.assert_allclose(b.values[:, 0], 3 * (b.time - 0.35), atol=1e-12)
    with pytest.raises(LogError, match="share no time"):
        align(fine, replace(coarse, time=coarse.time + 10))


@pytest.mark.parametrize("taper", ["hann", "boxcar"])
def test_a_sine_stands_in_the_spectrum_with_its_amplitude_and_frequency(taper):
    time = np.arange(1000) / 50
    values = np.column_stack([0.3 * np.sin(2 * np.pi * 2.5 * time) + 4.0, 0.1 * np.cos(2 * np.pi * 25 * time)])
    found = spectrum(Signal(time, values, ("a", "b"), "m", "world"), taper)
    peak = np.argmax(found.amplitude[:, 0])
    assert found.frequency_hz[peak] == pytest.approx(2.5)
    assert found.amplitude[peak, 0] == pytest.approx(0.3, rel=1e-9)  # bin centred: exact
    assert found.amplitude[0, 0] == pytest.approx(0.0, abs=1e-9)  # mean removed
    assert found.frequency_hz[-1] == pytest.approx(25)
    assert found.amplitude[-1, 1] == pytest.approx(0.1, rel=1e-9)  # the last bin has no mirror image


def test_a_spectrum_refuses_gaps_in_time_and_in_values():
    signal = ramp(stop=5)
    with pytest.raises(LogError, match=r"not sampled uniformly: .* at 1\.900 s"):
        keep = np.arange(signal.time.size) != 20
        spectrum(replace(signal, time=signal.time[keep], values=signal.values[keep]))
    hidden = signal.values.copy()
    hidden[7, 1] = np.nan
    with pytest.raises(LogError, match=r"b has no value at 0\.700 s"):
        spectrum(replace(signal, values=hidden))


def test_the_rate_of_one_sample_is_refused():
    assert ramp(rate=10).rate_hz == pytest.approx(10)
    with pytest.raises(LogError, match="one sample of a"):
        _ = Signal(np.zeros(1), np.zeros((1, 1)), ("a",), "m", "world").rate_hz


def recording() -> Recording:
    time = np.arange(5.0)
    signals = {
        "joint/position": named_signal("joint/position", time, np.zeros((5, 5))),
        "load": named_signal("load", time + 2, np.zeros((5, 3))),
    }
    return Recording("hold", "boom36", "nothing moves", signals)


def test_a_missing_signal_is_named_together_with_what_is_there():
    with pytest.raises(LogError, match="'hold' has no signal 'markers'; it has joint/position, load"):
        recording()["markers"]
    assert "load" in recording() and "markers" not in recording()


def test_a_recording_is_frozen_and_grows_only_as_a_new_one():
    first = recording()
    with pytest.raises(TypeError):
        first.signals["load"] = ramp()
    second = first.with_signals({"residual": ramp()})
    assert "residual" in second and "residual" not in first
    assert first.duration == 6.0 and Recording("", "", "", {}).duration == 0.0


def test_a_recording_travels_to_another_process():
    found = pickle.loads(pickle.dumps(recording()))
    assert found.name == "hold" and list(found.signals) == ["joint/position", "load"]
    np.testing.assert_array_equal(found["load"].time, recording()["load"].time)


@pytest.mark.parametrize("change", [{"unit": "deg"}, {"frame": "world"}, {"channels": ("q1", "q2", "q3", "q4", "q5")}])
def test_a_known_name_obliges(change):
    wrong = replace(recording()["joint/position"], **change)
    with pytest.raises(LogError, match=f"'joint/position' has {next(iter(change))}"):
        recording().with_signals({"joint/position": wrong})


def test_every_named_signal_fits_its_own_name():
    for name, quantity in QUANTITIES.items():
        width = len(quantity.channels) or 9
        made = Recording("r", "m", "", {name: named_signal(name, np.arange(2.0), np.zeros((2, width)))})[name]
        assert len(made.channels) == width and made.unit == quantity.unit
    assert point_channels("truck", 2) == ("truck1/x", "truck1/y", "truck1/z", "truck2/x", "truck2/y", "truck2/z")
    with pytest.raises(LogError, match="no signal called 'joint/positions'"):
        named_signal("joint/positions", np.arange(2.0), np.zeros((2, 5)))
