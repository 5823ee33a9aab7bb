"""The picture of a replay: what is furthest off comes first, and nothing stands on anything else."""

from dataclasses import replace
from functools import cache
from itertools import combinations
from pathlib import Path

import matplotlib
import numpy as np
import pytest
from matplotlib.figure import Figure
from matplotlib.text import Text

from boom_mj.machine import load_machine
from boom_mj.recording import Recording
from boom_mj.replay import Replay, replay
from boom_mj.report.overlay import PANELS, draw_overlay, overlay, worst_groups
from boom_mj.sensors import boom_lines, noise_levels, record
from boom_mj.simulation import CATALOGUE, make_plant, run_experiment

PLANT = make_plant(load_machine("boom36"))


@cache
def log() -> Recording:
    motion = run_experiment(PLANT, CATALOGUE["release_bow_vertical"])
    return record(motion, CATALOGUE["release_bow_vertical"], np.random.default_rng(3))


def replayed(*names: str, fault: str = "", by: float = 1.0) -> Replay:
    """A replay of those signals of the log, with the last channel of one of them scaled."""
    kept = {name: log()[name] for name in ("joint/position", "load", *names)}
    if fault:
        scale = np.r_[np.ones(len(kept[fault].channels) - 1), by]
        kept[fault] = replace(kept[fault], values=kept[fault].values * scale)
    return replay(PLANT, replace(log(), signals=kept))


EVERYTHING = tuple(name for name in log().signals if name in noise_levels(PLANT.machine) and name != "joint/position")


@pytest.mark.parametrize("fault", EVERYTHING)
def test_a_sensor_at_fault_comes_first(fault: str) -> None:
    found = replayed(*EVERYTHING, fault=fault, by=3.0)
    first, *others = worst_groups(found.groups)
    assert first.signal == fault and len(log()[fault].channels) - 1 in first.columns
    assert len(others) < PANELS and first.signal not in [group.signal for group in others]


def texts(figure: Figure) -> list[Text]:
    """What is to be read, with its place on the figure."""
    figure.canvas.draw()
    hidden = set()
    for axis in (axis for axes in figure.axes for axis in (axes.xaxis, axes.yaxis)):
        low, high = sorted(axis.get_view_interval())
        hidden |= {tick.label1 for tick in axis.get_major_ticks() if not low <= tick.get_loc() <= high}
    found = [t for t in figure.findobj(Text) if t.get_text().strip() and t.get_visible() and t not in hidden]
    return [t for t in found if t.get_window_extent().width]


@pytest.mark.parametrize("names", [EVERYTHING, ("markers",), ("cylinder/force",), ()])
def test_nothing_that_is_to_be_read_overlaps(names: tuple[str, ...]) -> None:
    figure = overlay(replayed(*names, fault=names[-1] if names else "", by=1.5))
    for one, other in combinations(texts(figure), 2):
        a, b = one.get_window_extent(), other.get_window_extent()
        assert not (a.shrunk(0.96, 0.9).overlaps(b.shrunk(0.96, 0.9))), (one.get_text(), other.get_text())
    for text in texts(figure):
        box = text.get_window_extent()
        assert box.x0 >= 0 and box.y0 >= 0 and box.x1 <= figure.bbox.x1 and box.y1 <= figure.bbox.y1, text.get_text()


def test_every_axis_of_a_signal_has_a_unit() -> None:
    figure = overlay(replayed(*EVERYTHING))
    labels = [axes.get_ylabel().replace("residual\n", "") for axes in figure.axes[: 2 * PANELS]]
    assert set(labels) <= {"m", "mm", "kN", "m/s²", "mrad/s"} and len(labels) == 2 * PANELS


def test_the_line_of_the_boom_goes_from_the_ground_to_the_tip() -> None:
    motion = run_experiment(PLANT, CATALOGUE["slew_t"])
    steps = [0, len(motion.time) // 2]
    bent, rigid = boom_lines(motion, steps), boom_lines(motion, steps, bent=False)
    assert np.allclose(bent[:, 0, 2], 0) and np.allclose(bent[:, -2], motion.sensor("marker12")[steps])
    length = np.linalg.norm(np.diff(rigid, axis=1), axis=2).sum(axis=1)  # links stay as long as they are
    np.testing.assert_allclose(length, length[0])
    assert (rigid[:, -1, 2] > bent[:, -1, 2]).all()


def test_a_picture_is_written(tmp_path: Path) -> None:
    before = dict(matplotlib.rcParams)
    draw_overlay(replayed("markers"), tmp_path / "p.png")
    assert (tmp_path / "p.png").read_bytes()[:4] == b"\x89PNG" and dict(matplotlib.rcParams) == before
