"""render: an experiment or a recorded motion as a labelled camera data set."""

import json
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from boom_mj.cli.arguments import (
    EXPERIMENTS,
    AsJson,
    Cluster,
    Hinges,
    find_machine,
    last_states_beside,
    output_folder,
    output_path,
)
from boom_mj.errors import InputError

if TYPE_CHECKING:
    from boom_mj.recording import Recording
    from boom_mj.simulation import Trajectory

LAYOUTS = ("coco", "nerfstudio", "bop", "mcap")
KINDS = ("light", "texture", "pose")


def command(
    what: Annotated[str, typer.Argument(metavar="MACHINE.toml|LOG", help="A machine, or a log to replay.")],
    output: Annotated[Path, typer.Option("-o", metavar="DIR", help="Folder of the data set: new, empty or begun.")],
    experiment: Annotated[
        str, typer.Option(help=f"What a machine does: a .toml of your own, or one of: {', '.join(EXPERIMENTS)}.")
    ] = "release_stretched_vertical",
    machine: Annotated[str | None, typer.Option(help="Machine of a log; the one that it names if left out.")] = None,
    camera: Annotated[
        list[str] | None, typer.Option(help="Camera to use; all of the machine file if left out.")
    ] = None,
    start: Annotated[float, typer.Option(min=0, help="Time of the first frame, s.")] = 0.0,
    stop: Annotated[
        float | None, typer.Option(help="Time of the last frame, s; the end of the motion if left out.")
    ] = None,
    every: Annotated[int, typer.Option(min=1, help="Take each Nth frame.")] = 1,
    scale: Annotated[float, typer.Option(min=0.02, max=4, help="Factor on width and height of the pictures.")] = 1.0,
    jpeg: Annotated[int, typer.Option(min=0, max=100, help="JPEG of this quality; 0: PNG.")] = 0,
    depth: Annotated[bool, typer.Option("--depth", help="Depth, too: 16 bit PNG in 4 mm; 0 is sky.")] = False,
    masks: Annotated[bool, typer.Option("--masks", help="Which body every pixel shows, too: PNG.")] = False,
    distortion: Annotated[bool, typer.Option(help="Lenses of the machine file, or ideal ones.")] = True,
    noise: Annotated[bool, typer.Option("--noise", help="With the pixel noise of the machine file.")] = False,
    blur: Annotated[int, typer.Option(min=1, max=64, help="Instants within the exposure; 1: sharp.")] = 1,
    rolling: Annotated[int, typer.Option(min=1, max=64, help="Row bands of a rolling shutter; 1: global.")] = 1,
    randomise: Annotated[
        str, typer.Option(help=f"Drawn anew for every frame: any of {', '.join(KINDS)}; with commas.")
    ] = "",
    seed: Annotated[int, typer.Option(min=0, help="Seed of noise and randomisation.")] = 0,
    calibration: Annotated[bool, typer.Option(help="With pictures of the chequerboard.")] = True,
    layout: Annotated[
        str, typer.Option(help=f"Layouts to write, of {', '.join(LAYOUTS)}; with commas.")
    ] = "coco,nerfstudio",
    sheet: Annotated[Path | None, typer.Option(metavar="PNG", help="Contact sheet to draw.")] = None,
    hinges: Hinges = 1,
    jobs: Annotated[int, typer.Option("--jobs", "--workers", min=1, max=64, help="Processes that render.")] = 2,
    cluster: Cluster = None,
    as_json: AsJson = False,
) -> None:
    """Render a motion in front of the machine's cameras, with labels; killed, the same call finishes the rest.

    Example: python -m boom_mj render boom36 -o film --experiment fold_in --stop 20 --every 4 --masks --depth
    """
    from boom_mj.cameras.describe import describe
    from boom_mj.cameras.film import film_of
    from boom_mj.cameras.render import render_dataset
    from boom_mj.cameras.rig import rig_of
    from boom_mj.cameras.shooting import Look, frames_of
    from boom_mj.cli.progress import progress

    if sheet is not None:
        output_path(sheet, ".png")
    wanted, drawn = _choice(layout, LAYOUTS, "layout"), _choice(randomise, KINDS, "randomise")
    output_folder(output)
    with last_states_beside(output):
        trajectory, recording = _motion(what, experiment, machine, hinges)
    last = float(recording.duration if stop is None else stop)
    if not start <= last <= trajectory.time[-1] + 1e-6:
        raise InputError(f"stop = {last}: the motion runs to {trajectory.time[-1]:.3f} s, and starts at {start}")
    film = film_of(trajectory, rig_of(trajectory.plant.machine, camera or (), scale, distortion))
    look = Look(".jpg" if jpeg else ".png", jpeg or 95, depth, masks, blur, rolling, noise, frozenset(drawn), seed)
    frames = frames_of(film, start, last, every)
    options = {
        "start": start, "stop": last, "every": every, "scale": scale, "distortion": distortion, "hinges": hinges,
        "jpeg": jpeg, "depth": depth, "masks": masks, "noise": noise, "blur": blur, "rolling": rolling,
        "randomise": sorted(drawn), "seed": seed,
    }  # fmt: skip
    dataset = describe(film, frames, look, calibration, recording.name, recording.description, options)
    with progress("frames") as report:
        render_dataset(film, frames, look, dataset, output, wanted, report, jobs, cluster)
    if "mcap" in wanted:
        from boom_mj.logs import write_mcap
        from boom_mj.logs.pictures import picture_messages
        from boom_mj.sensors import boom_scene

        scene = boom_scene(trajectory, fixed={camera.name: camera.view.pose for camera in film.rig})
        write_mcap(recording, output / "dataset.mcap", scene=scene, also=picture_messages(output, dataset))
    if sheet is not None:
        from boom_mj.cameras.pictures import contact_sheet

        contact_sheet(output, dataset, sheet)
    cameras = [camera.name for camera in film.rig]
    if as_json:
        told = {"folder": str(output), "frames": len(frames), "cameras": cameras, "layouts": sorted(wanted)}
        print(json.dumps(told, indent=1))
    else:
        print(f"data set     {output}: {len(frames)} frames of {', '.join(cameras)}")
        print(f"layouts      {', '.join(sorted(wanted))}")
    if sheet is not None:
        print(f"wrote {sheet}", file=sys.stderr)


def _choice(text: str, known: tuple[str, ...], option: str) -> frozenset[str]:
    chosen = frozenset(part for part in text.split(",") if part)
    if unknown := sorted(chosen - set(known)):
        raise InputError(f"--{option}: there is no {unknown[0]!r}; known: {', '.join(known)}")
    return chosen


def _motion(what: str, experiment: str, machine: str | None, hinges: int) -> "tuple[Trajectory, Recording]":
    """A motion from time 0 on, and its recording without noise."""
    from boom_mj.logs import read_log
    from boom_mj.replay import replay
    from boom_mj.sensors import measure
    from boom_mj.simulation import load_experiment, make_plant, run_experiment

    path = Path(what)
    if path.suffix in ("", ".toml") and not path.is_dir():
        plan = load_experiment(experiment)
        trajectory = run_experiment(make_plant(find_machine(machine or what), hinges), plan)
        return trajectory, measure(trajectory, plan.name, plan.description, plan.duration)
    if not path.exists():
        raise InputError(f"{path}: there is no such log")
    log = read_log(path)
    if machine is None and not log.machine:
        raise InputError(f"{path}: the log does not name its machine; say which with --machine")
    trajectory = replay(make_plant(find_machine(machine or log.machine), hinges), log).trajectory
    duration = float(log["joint/position"].time[-1] - log["joint/position"].time[0])
    return trajectory, measure(trajectory, log.name, f"replayed: {log.description}", duration)
