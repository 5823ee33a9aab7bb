"""simulate: an experiment as a recording."""

from pathlib import Path
from typing import Annotated

import numpy as np
import typer

from boom_mj.cli.arguments import Hinges, MachineFile, find_machine, last_states_beside, output_path
from boom_mj.effects import parse_effect
from boom_mj.logs import write_mcap
from boom_mj.sensors import boom_scene, record
from boom_mj.simulation import CATALOGUE, Trajectory, load_experiment, make_plant, run_experiment


def command(
    machine: MachineFile,
    experiment: Annotated[str, typer.Argument(help=f"A .toml of your own, or one of: {', '.join(CATALOGUE)}.")],
    output: Annotated[Path | None, typer.Option("-o", metavar="OUT.mcap", help="Recording to write.")] = None,
    hinges: Hinges = 1,
    effect: Annotated[list[str] | None, typer.Option(metavar="ID:key=value,...", help="Effect to add.")] = None,
    seed: Annotated[int, typer.Option(help="Of the sensor noise.")] = 0,
    scene: Annotated[bool, typer.Option("--scene", help="Add /tf and /scene: a viewer shows the boom moving.")] = False,
    noise: Annotated[bool, typer.Option(help="Sensor noise of the machine file.")] = True,
) -> None:
    """Simulate an experiment from rest and write what the machine's sensors record, as MCAP."""
    if output is not None:
        output_path(output, ".mcap")
    plan, effects = load_experiment(experiment), [parse_effect(text) for text in effect or []]
    plant = make_plant(find_machine(machine), hinges, effects)
    with last_states_beside(output):
        trajectory = run_experiment(plant, plan)
    rng = np.random.default_rng(seed) if noise else None
    recording = record(trajectory, plan, rng)
    if output is not None:
        write_mcap(recording, output, scene=boom_scene(trajectory) if scene else None)
    _print_summary(trajectory, plan.duration, output)


def _print_summary(trajectory: Trajectory, duration: float, output: Path | None) -> None:
    tip = trajectory.sensor(f"marker{len(trajectory.plant.machine.sensors.markers_x) * 4}")
    low, high = tip.min(axis=0), tip.max(axis=0)
    print(f"simulated     {duration:g} s, {len(trajectory.time)} steps")
    print(f"tip at start  x {tip[0, 0]:8.3f}  y {tip[0, 1]:8.3f}  z {tip[0, 2]:8.3f} m")
    print(f"tip at end    x {tip[-1, 0]:8.3f}  y {tip[-1, 1]:8.3f}  z {tip[-1, 2]:8.3f} m")
    print(f"tip moved     x {np.ptp(tip[:, 0]):8.3f}  y {np.ptp(tip[:, 1]):8.3f}  z {high[2] - low[2]:8.3f} m")
    force = trajectory.cylinder_force / 1000
    for k in range(2):
        print(f"cylinder {k + 2}    {force[:, k].min():.1f} .. {force[:, k].max():.1f} kN")
    if output is not None:
        print(f"recording     {output}")
