"""How fast labelled pictures are made, against a bare mujoco.Renderer loop with the same encoding.

Run: MUJOCO_GL=egl .venv/bin/python benchmarks/rendering.py [-o RESULT.json]   (about 5 minutes on two cores)
The loops take turns over the same instants in one process; medians of wall and CPU seconds per frame. Whole data sets
include the start of their processes.
"""

import json
import sys
import tempfile
import time
from collections.abc import Callable
from contextlib import ExitStack
from functools import partial
from pathlib import Path
from statistics import median

import mujoco

from boom_mj.cameras.film import Film, film_of
from boom_mj.cameras.lens import Lens
from boom_mj.cameras.rig import rig_of
from boom_mj.cameras.shooting import Frame, Look, frames_of, render_frames, shoot
from boom_mj.cameras.studio import Studio, open_renderer
from boom_mj.machine import load_machine
from boom_mj.simulation import CATALOGUE, make_plant, run_experiment

ROOT = Path(__file__).parents[1]
TURNS, FRAMES = 9, 6  # rounds, and frames in each
WHOLE = 48  # frames of a data set
CLEAN = Look()


def bare(
    film: Film, lenses: dict[str, Lens], renderers: dict[str, mujoco.Renderer], frames: list[Frame], folder: Path
) -> None:
    """Pictures without labels, as one would write it by hand; a lens that distorts costs its remapping."""
    data = mujoco.MjData(film.model)
    for frame in frames:
        data.qpos[:] = film.at(frame.time)
        mujoco.mj_kinematics(film.model, data)
        mujoco.mj_camlight(film.model, data)
        renderer = renderers[frame.camera]
        renderer.update_scene(data, frame.camera)
        picture = lenses[frame.camera].picture(renderer.render())
        (folder / f"{frame.camera}_{frame.number}.png").write_bytes(CLEAN.encode(picture))


def labelled(studio: Studio, look: Look, frames: list[Frame], folder: Path) -> None:
    """The same with labels."""
    for frame in frames:
        shoot(studio, frame, look, folder)


def per_frame(works: dict[str, Callable[[], None]], frames: int) -> dict[str, tuple[float, float]]:
    """Median wall and CPU seconds per frame of works that take turns."""
    found: dict[str, list[tuple[float, float]]] = {name: [] for name in works}
    for turn in range(TURNS + 1):
        for name, work in works.items():
            wall, cpu = time.perf_counter(), time.process_time()
            work()
            cost = (time.perf_counter() - wall) / frames, (time.process_time() - cpu) / frames
            if turn:  # the first warms up
                found[name].append(cost)
    return {name: (median(w for w, _ in costs), median(c for _, c in costs)) for name, costs in found.items()}


def loops(ideal: Film, real: Film, folder: Path) -> dict[str, tuple[float, float]]:
    """Wall and CPU seconds per frame."""
    frames = frames_of(ideal, 8.0, 8.0 + (FRAMES // 3 - 1) * 0.5, 10)
    everything, works = Look(depth=True, masks=True), {}
    with ExitStack() as stack:
        for kind, film in (("ideal", ideal), ("distorting", real)):
            studio = stack.enter_context(Studio(film))
            opened: dict[tuple[int, int], mujoco.Renderer] = {}
            renderers = {}
            for name, lens in studio.lenses.items():
                size = lens.source.width, lens.source.height
                if size not in opened:
                    opened[size] = stack.enter_context(open_renderer(film.model, lens.source))
                renderers[name] = opened[size]
            works[f"bare loop, {kind} lenses"] = partial(bare, film, studio.lenses, renderers, frames, folder)
            works[f"labelled, {kind} lenses"] = partial(labelled, studio, CLEAN, frames, folder)
        works["labelled, distorting lenses, depth and masks"] = partial(labelled, studio, everything, frames, folder)
        return per_frame(works, len(frames))


def whole(film: Film, workers: int) -> float:
    """Frames per second of a data set, start of the workers included."""
    frames = frames_of(film, 8.0, 8.0 + (WHOLE // 3 - 1) / 20, 1)
    with tempfile.TemporaryDirectory() as folder:
        began = time.perf_counter()
        render_frames(film, frames, CLEAN, Path(folder), lambda done, total: None, workers)
        return len(frames) / (time.perf_counter() - began)


def main() -> None:
    plant = make_plant(load_machine(ROOT / "models" / "boom36.toml"), 1)
    motion = run_experiment(plant, CATALOGUE["release_stretched_vertical"])
    ideal, real = (film_of(motion, rig_of(plant.machine, distortion=bent)) for bent in (False, True))
    with tempfile.TemporaryDirectory() as folder:
        costs = loops(ideal, real, Path(folder))
    rates = {workers: whole(ideal, workers) for workers in (1, 2, 4)}
    for name, (wall, cpu) in costs.items():
        ratio = costs[f"bare loop, {'ideal' if 'ideal' in name else 'distorting'} lenses"][0] / wall
        print(f"{name:46s} {wall:6.3f} s wall {cpu:6.3f} s CPU per frame; {ratio:.2f} x the bare loop's rate")
    for workers, rate in rates.items():
        print(f"{WHOLE} frames, {workers} workers {rate:6.2f} frames per s")
    if "-o" in sys.argv:
        Path(sys.argv[sys.argv.index("-o") + 1]).write_text(json.dumps({"loops": costs, "workers": rates}))


if __name__ == "__main__":
    main()
