"""Films: what is measured stands where it was, as far from what is simulated as one asked for."""

from pathlib import Path

import cv2
import numpy as np
import pytest
from opengl import can_render

from boom_mj.cameras import cinema
from boom_mj.cameras.cinema import _pixels, record_film, reel_of
from boom_mj.cli import run
from boom_mj.logs import write_mcap
from boom_mj.machine import load_machine
from boom_mj.sensors import measure
from boom_mj.simulation import CATALOGUE, make_plant, run_experiment

PLANT = make_plant(load_machine("boom36"), 2)
MOTION = run_experiment(PLANT, CATALOGUE["slew_t"])
LOG = measure(MOTION, "slew_t", "ideal", 30.0)


@pytest.mark.parametrize("factor", [1.0, 5.0])
def test_a_log_of_the_simulation_stands_on_it(factor: float) -> None:
    reel = reel_of(MOTION, LOG, "slew_t", factor, speed=10.0)
    assert len(reel.time) == 76  # 30 s, ten times as fast, 25 pictures a second, with both ends
    # the log's samples lie between steps of 5 ms, in which the tip moves by some tenths of a millimetre
    np.testing.assert_allclose(reel.measured, reel.simulated, atol=factor * 5e-4)
    bent = reel.qpos[:, PLANT.elastic]
    steps = np.rint(reel.time / PLANT.model.opt.timestep).astype(int)
    np.testing.assert_allclose(bent, factor * MOTION.qpos[np.ix_(steps, PLANT.elastic)])


def test_what_is_off_is_exaggerated_alike() -> None:
    markers = LOG["markers"]
    off = LOG.with_signals({"markers": type(markers)(markers.time, markers.values + 0.01, *rest(markers))})
    reel = reel_of(MOTION, off, "slew_t", 10.0, speed=10.0)
    assert np.median(reel.measured - reel.simulated) == pytest.approx(0.1, rel=1e-6)


def rest(signal: object) -> tuple:
    return signal.channels, signal.unit, signal.frame


def test_all_that_moves_is_in_the_picture() -> None:
    reel = reel_of(MOTION, LOG, "slew_t", 3.0, speed=10.0)
    for points in reel.simulated:
        pixels = _pixels(reel.eye, PLANT.model.vis.global_.fovy, points)
        assert (pixels > 0).all() and (pixels < cinema.SIZE).all()


@pytest.mark.skipif(not can_render(), reason="no OpenGL here")
@pytest.mark.parametrize("suffix", [".mp4", ".webm"])
def test_a_film_has_all_its_pictures(suffix: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MUJOCO_GL", "egl")
    record_film(reel_of(MOTION, LOG, "slew_t", 3.0, speed=50.0), path := tmp_path / f"film{suffix}")
    film = cv2.VideoCapture(str(path))
    pictures = [film.read()[1] for _ in range(int(film.get(cv2.CAP_PROP_FRAME_COUNT)))]
    assert len(pictures) == 16 and pictures[0].shape == (*cinema.SIZE[::-1], 3)
    assert np.abs(pictures[0].astype(int) - pictures[-1]).max() > 100  # something has moved
    assert [p.name for p in tmp_path.iterdir()] == [path.name]


def test_wrong_films_are_refused_before_any_work(tmp_path: Path, capsys: pytest.CaptureFixture) -> None:
    write_mcap(LOG, log := tmp_path / "log.mcap")
    for words, told in (
        (["view", str(log), "--exaggerate", "3"], "--record"),
        (["view", str(log), "--record", str(tmp_path / "film.gif")], ".mp4 or .webm"),
        (["view", str(log), "--record", str(tmp_path / "nowhere" / "film.mp4")], "there is no folder"),
    ):
        assert run(words) == 2
        assert told in capsys.readouterr().err
