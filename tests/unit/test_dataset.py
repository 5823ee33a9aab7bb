"""A dataset: which recordings train, and what is simulated."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from boom_mj.errors import LogError, LogWarning
from boom_mj.estimation.dataset import Dataset
from boom_mj.logs import read_log
from boom_mj.machine import load_machine
from boom_mj.recording import Recording, window
from boom_mj.systems.boom import BoomSystem
from boom_mj.systems.predictor import Predictor, dataset_of

ROOT = Path(__file__).parents[2]
SYSTEM = BoomSystem(load_machine(ROOT / "models" / "boom36.toml"))
LOG = read_log(ROOT / "logs" / "independent_release_stretched_vertical.mcap")


def between(start: float, stop: float, **others: tuple[float, float]) -> Recording:
    """The log from start to stop, s, but for signals with a span of their own."""
    spans = {name: others.get(name.partition("/")[0], (start, stop)) for name in LOG.signals}
    return replace(LOG, signals={name: window(LOG[name], *span) for name, span in spans.items()})


def dataset(*recordings: Recording) -> Dataset:
    return dataset_of(SYSTEM, recordings, 1)


def test_the_first_part_of_an_extending_recording_trains_and_nothing_is_simulated_again() -> None:
    predictor = Predictor(SYSTEM, dataset(*[between(7.0, 9.0)] * 3), threads=1)
    level = SYSTEM.facts.fidelity.rough
    (whole,), before = predictor.predict([()], level), predictor.simulated_s
    other = predictor.extending(2)
    data, extended = predictor.data, other.data
    assert (data.trained, extended.trained) == ((0,), (0, 2))
    (part,) = other.predict([()], level, extended.trained)
    assert other.simulated_s == before > 0
    own = data.recording_of
    assert np.isnan(part[own == 1]).all() and np.array_equal(part[own != 1], whole[own != 1], equal_nan=True)
    assert set(own[data.train]) == {0} and set(own[extended.train]) == {0, 2}
    assert set(own[extended.held_out]) == {1, 2}
    assert data.time[extended.train & (own == 2)].max() < 1.2 <= data.time[extended.held_out & (own == 2)].min()


@pytest.mark.parametrize("joint", [(7.02, 9.0), (7.16, 9.0), (7.0, 8.9), (7.16, 8.9)])
def test_samples_outside_the_joint_angles_are_left_out_and_said(joint: tuple[float, float]) -> None:
    with pytest.warns(LogWarning, match=r"samples of imu/.* outside the .* s that drive the model"):
        data = dataset(between(7.0, 9.0, joint=joint))
    whole = dataset(between(*joint))
    assert np.array_equal(data.measured, whole.measured) and np.array_equal(data.noise, whole.noise)


def test_samples_within_the_joint_angles_are_all_compared(recwarn: pytest.WarningsRecorder) -> None:
    dataset(between(7.0, 9.0))
    assert not recwarn.list


def test_signals_without_a_time_in_common_are_refused_with_both_spans() -> None:
    with pytest.raises(LogError, match=r"no sample from 7.000 to 8.000 s; it runs from 8.5"):
        dataset(between(8.5, 9.0, joint=(7.0, 8.0)))


def test_a_table_has_all_channels_of_a_recording_on_one_grid() -> None:
    data = dataset(between(7.0, 9.0), between(7.0, 8.0))
    table, own = data.table(1), data.of(1)
    assert table.log is data.recordings[1] and table.channels == tuple(own)
    assert table.time[:2] == pytest.approx(data.block_s * np.array([0.5, 1.5])) and table.time[-1] >= 1.0
    for column, channel in enumerate(own):
        seen = table.mean[:, column]
        assert np.array_equal(np.flatnonzero(np.isfinite(seen)), channel.blocks[np.isfinite(channel.measured)])
        assert np.array_equal(seen[channel.blocks], channel.measured, equal_nan=True)
        deviation = np.hypot(channel.noise / np.sqrt(channel.count), channel.rounding)
        assert table.noise[channel.blocks, column] == pytest.approx(deviation)
    turned = table.saying(-np.concatenate([channel.measured for channel in own]))
    assert np.array_equal(turned.mean, -table.mean, equal_nan=True)


def test_there_is_something_to_learn_from() -> None:
    for recordings, training in (([], 0), ([], 1), ([between(7.0, 9.0)], 0)):
        with pytest.raises(LogError, match="at least one recording"):
            dataset_of(SYSTEM, recordings, training)


def test_windows_are_numbered_through_all_recordings() -> None:
    data = dataset(between(7.0, 9.0), between(7.0, 8.0))
    number = np.floor(data.time / data.correlation_s)
    assert np.array_equal(data.windows, data.recording_of * (number.max() + 1) + number)
    assert len({*data.windows[data.recording_of == 0]} & {*data.windows[data.recording_of == 1]}) == 0
