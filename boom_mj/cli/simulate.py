"""simulate: an experiment as a recording, or over ranges of values as many."""

import json
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from boom_mj.cli.arguments import (
    EXPERIMENTS,
    AsJson,
    Cluster,
    EffectFiles,
    Hinges,
    Jobs,
    MachineFile,
    find_machine,
    last_states_beside,
    output_path,
)
from boom_mj.errors import BoomError, InputError

if TYPE_CHECKING:
    from boom_mj.simulation import Experiment, Trajectory
    from boom_mj.sweeping import Sweep


def command(
    machine: MachineFile,
    experiment: Annotated[str, typer.Argument(help=f"A .toml of your own, or one of: {', '.join(EXPERIMENTS)}.")],
    output: Annotated[
        Path | None, typer.Option("-o", metavar="OUT.mcap|DIR", help="Recording to write; of a sweep, its folder.")
    ] = None,
    hinges: Hinges = 1,
    effect: Annotated[
        list[str] | None,
        typer.Option(
            metavar="ID:key=value,...",
            help="Effect to add, in SI units; `gap effects` lists them; several may be given.",
        ),
    ] = None,
    own_effects: EffectFiles = None,
    seed: Annotated[int, typer.Option(help="Seed of the sensor noise.")] = 0,
    scene: Annotated[bool, typer.Option("--scene", help="Add /tf and /scene: a viewer shows the boom moving.")] = False,
    noise: Annotated[bool, typer.Option(help="With the sensor noise of the machine file.")] = True,
    sweep: Annotated[
        list[str] | None,
        typer.Option(
            metavar="RANGE", help="Range of a machine value or of an effect's parameter; may come several times."
        ),
    ] = None,
    draws: Annotated[
        int | None, typer.Option(min=1, help="Points drawn evenly from ranges without /N; a grid if left out.")
    ] = None,
    jobs: Jobs = 1,
    cluster: Cluster = None,
    as_json: AsJson = False,
) -> None:
    """Simulate an experiment from rest and write what the machine's sensors record, as MCAP.

    --sweep simulates it over ranges: link3.mass=500..700/5 (a value of the machine file),
    tip_payload:mass=0..100/11, link_stiffness:link=3,axis=v,factor=0.8..1.2/5. The folder gets a recording per point
    and table.csv; stopped, the same call does the rest.

    Example: python -m boom_mj simulate boom36 release_bow_vertical -o log.mcap --effect tip_payload:mass=40
    """
    from boom_mj.effects import parse_effect
    from boom_mj.simulation import load_experiment, make_plant, run_experiment

    plan, effects = load_experiment(experiment), [parse_effect(text) for text in effect or []]
    if sweep:
        if output is None:
            raise InputError("a sweep needs a folder for its recordings: -o DIR")
        from boom_mj.sweeping import Axis, Sweep

        axes = tuple(Axis.parse(text) for text in sweep)
        wanted = Sweep(find_machine(machine), plan, axes, hinges, tuple(effects), draws, noise, seed, scene)
        _sweep(wanted, output, jobs, cluster, as_json)
        return
    if draws is not None or cluster is not None or jobs > 1:
        raise InputError("--draws, --jobs and --cluster are for a sweep: give a range with --sweep")
    if output is not None:
        output_path(output, ".mcap")
    import numpy as np

    from boom_mj.logs import write_mcap
    from boom_mj.sensors import boom_scene, record

    plant = make_plant(find_machine(machine), hinges, effects)
    with last_states_beside(output):
        trajectory = run_experiment(plant, plan)
    rng = np.random.default_rng(seed) if noise else None
    recording = record(trajectory, plan, rng)
    if output is not None:
        write_mcap(recording, output, scene=boom_scene(trajectory) if scene else None)
        if hinges == 1:
            print("one hinge per elastic coordinate; for `gap diagnose` simulate with --hinges 4", file=sys.stderr)
    if as_json:
        print(json.dumps(_document(trajectory, plan, output), indent=1))
    else:
        _print_summary(trajectory, plan.duration, output)


def _sweep(wanted: "Sweep", folder: Path, jobs: int, cluster: str | None, as_json: bool) -> None:
    from boom_mj.cli.progress import progress
    from boom_mj.sweeping import read_rows, run_sweep

    with progress() as report:
        for done, error in run_sweep(wanted, folder, jobs, cluster):
            if error:
                print(f"warning: {error}", file=sys.stderr)
            report("points", done, len(wanted))
    rows = [row for row in read_rows(folder) if row["point"] < len(wanted)]
    for row in rows:
        if "error" in row:
            print(f"warning: point {row['point']:06d}: {row['error']}", file=sys.stderr)
    made = sum("error" not in row for row in rows)
    if as_json:
        told: dict[str, Any] = {
            "machine": wanted.machine.name,
            "experiment": wanted.experiment.name,
            "folder": str(folder),
        }
        told |= {"table": str(folder / "table.csv"), "points": len(wanted), "recorded": made}
        failed = {f"{row['point']:06d}": row["error"] for row in rows if "error" in row}
        print(json.dumps({**told, "failed": failed}, indent=1))
    else:
        _print_made(made, wanted, folder)
    if made < len(wanted):
        raise BoomError(f"{len(wanted) - made} of {len(wanted)} points have no recording")


def _print_made(made: int, wanted: "Sweep", folder: Path) -> None:
    print(f"points        {made} of {len(wanted)} recorded in {folder}")
    print(f"table         {folder / 'table.csv'}")


def _document(trajectory: "Trajectory", plan: "Experiment", output: Path | None) -> dict[str, Any]:
    from boom_mj.sweeping import figures

    found = figures(trajectory)
    return {
        "machine": trajectory.plant.machine.name,
        "experiment": plan.name,
        "simulated_s": plan.duration,
        "steps": len(trajectory.time),
        "recording": None if output is None else str(output),
        "tip_m": {part: [float(found[f"tip_{part}_{axis}"]) for axis in "xyz"] for part in ("start", "end", "range")},
        "cylinders_n": {
            f"cylinder{k}": {end: float(found[f"cylinder{k}_{end}"]) for end in ("min", "max")} for k in (2, 3)
        },
    }


def _print_summary(trajectory: "Trajectory", duration: float, output: Path | None) -> None:
    from boom_mj.sweeping import figures

    found = figures(trajectory)
    print(f"simulated     {duration:g} s, {len(trajectory.time)} steps")
    for label, name in (("tip at start", "tip_start"), ("tip at end  ", "tip_end"), ("tip moved   ", "tip_range")):
        x, y, z = (found[f"{name}_{axis}"] for axis in "xyz")
        print(f"{label}  x {x:8.3f}  y {y:8.3f}  z {z:8.3f} m")
    for k in (2, 3):
        print(f"cylinder {k}    {found[f'cylinder{k}_min'] / 1000:.1f} .. {found[f'cylinder{k}_max'] / 1000:.1f} kN")
    if output is not None:
        print(f"recording     {output}")
