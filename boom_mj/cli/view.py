"""view: an experiment or a log, moving, in MuJoCo's viewer or as a film."""

import json
import os
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from boom_mj.cli.arguments import AsJson, Hinges, find_machine, output_path
from boom_mj.errors import BoomError, InputError

if TYPE_CHECKING:
    from boom_mj.recording import Recording
    from boom_mj.simulation import Trajectory

FRAME = 1 / 30  # s
FILMS = (".mp4", ".webm")
Sync = Callable[[Any, Any], bool]
"""Shows a state, (MjModel, MjData); False once the viewer is closed."""


def command(
    what: Annotated[str, typer.Argument(metavar="MACHINE.toml|LOG.mcap", help="A machine, or a log to replay.")],
    experiment: Annotated[
        str, typer.Option(help="What a machine does: a name that `simulate` knows, or a .toml.")
    ] = "fold_in",
    machine: Annotated[str | None, typer.Option(help="Machine of the log; the one that it names if left out.")] = None,
    hinges: Hinges = 1,
    speed: Annotated[float, typer.Option(min=0.01, max=100, help="Speed, in times real time.")] = 1.0,
    web: Annotated[bool, typer.Option("--web", help="In a browser even where there is a screen.")] = False,
    port: Annotated[int, typer.Option(min=1, max=65535, help="Port of the web viewer.")] = 8080,
    laps: Annotated[int, typer.Option(min=0, help="How often to show it; 0: until the viewer is closed.")] = 0,
    film: Annotated[
        Path | None, typer.Option("--record", metavar="FILM.mp4|.webm", help="Film to make instead: twin and log.")
    ] = None,
    exaggerate: Annotated[
        float, typer.Option(min=1, max=100, help="Factor on the film's deflections, and on measured - simulated.")
    ] = 1.0,
    as_json: AsJson = False,
) -> None:
    """Show an experiment or a replayed log in MuJoCo's viewer: a window where there is a screen, else in a browser.

    --record draws a film instead, without a screen: the boom as it is simulated, and of a log the markers as measured.

    Example: python -m boom_mj view boom36 --experiment slew_t --speed 2
    """
    import mujoco

    from boom_mj.logs import read_mcap
    from boom_mj.replay import replay
    from boom_mj.simulation import load_experiment, make_plant, run_experiment

    if film is None and (exaggerate != 1 or as_json):
        raise InputError("--exaggerate and --json are for films: say where with --record FILM.mp4")
    if film is not None:
        if film.suffix not in FILMS:
            raise InputError(f"{film}: a film is a {' or '.join(FILMS)} file")
        output_path(film)
    log = None
    if Path(what).suffix == ".mcap":
        log = read_mcap(what)
        motion = replay(make_plant(find_machine(machine or log.machine), hinges), log).trajectory
    else:
        motion = run_experiment(make_plant(find_machine(what), hinges), load_experiment(experiment))
    if film is not None:
        title = log.name if log else f"{motion.plant.machine.name}: {experiment}"
        told = _record(motion, log, title, film, exaggerate, speed)
        print(json.dumps(told, indent=1) if as_json else film)
        return
    screen = any(os.environ.get(name) for name in ("DISPLAY", "WAYLAND_DISPLAY")) or sys.platform in ("win32", "darwin")
    try:
        (_in_browser if web or not screen else _in_window)(motion, speed, port, laps)
    except (ImportError, OSError, RuntimeError, mujoco.FatalError) as error:
        where = f"a browser (port {port})" if web or not screen else "a window"
        raise BoomError(f"MuJoCo's viewer cannot run in {where} here: {error}") from error


def _record(
    motion: "Trajectory", log: "Recording | None", title: str, path: Path, exaggerate: float, speed: float
) -> dict[str, Any]:
    from boom_mj.cameras.cinema import RATE, record_film, reel_of
    from boom_mj.cli.progress import progress

    reel = reel_of(motion, log, title, exaggerate, speed)
    with progress() as report:
        record_film(reel, path, lambda done, total: report("pictures", done, total))
    told = {"film": str(path), "pictures": len(reel.time), "pictures_per_s": RATE}
    return {**told, "speed": speed, "exaggerate": exaggerate}


def _in_window(motion: "Trajectory", speed: float, port: int, laps: int) -> None:
    import mujoco
    import mujoco.viewer

    model, data = motion.plant.model, mujoco.MjData(motion.plant.model)
    with mujoco.viewer.launch_passive(model, data) as viewer:

        def sync(model: Any, data: Any) -> bool:
            viewer.sync()
            return bool(viewer.is_running())

        _play(motion, data, sync, speed, laps)


def _in_browser(motion: "Trajectory", speed: float, port: int, laps: int) -> None:
    import mujoco
    from mujoco.studio import app, launch_web, viewer_protocol

    data = mujoco.MjData(motion.plant.model)
    config = viewer_protocol.ViewerConfig(title=f"boom_mj {motion.plant.machine.name}", gfx="web", http_port=port)
    with launch_web.launch(config, plugins=[app.App()]) as viewer:
        print(
            f"http://localhost:{port} shows it; anyone who reaches that port sees it too; Ctrl-C ends", file=sys.stderr
        )

        def sync(model: Any, data: Any) -> bool:
            viewer.sync(model, data)
            return bool(viewer.is_running())

        _play(motion, data, sync, speed, laps)


def _play(motion: "Trajectory", data: Any, sync: Sync, speed: float, laps: int) -> None:
    """Set the states of a motion one after the other, in time."""
    import mujoco

    model, lap = motion.plant.model, 0
    while laps == 0 or lap < laps:
        began, lap = time.monotonic(), lap + 1
        while (now := speed * (time.monotonic() - began)) <= motion.time[-1]:
            step = min(int(now / model.opt.timestep), len(motion.time) - 1)
            data.time, data.qpos[:], data.qvel[:] = motion.time[step], motion.qpos[step], motion.qvel[step]
            mujoco.mj_forward(model, data)
            if not sync(model, data):
                return
            time.sleep(FRAME)
