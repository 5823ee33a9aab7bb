"""replay: the joint angles of a log drive the model."""

import json
import sys
from pathlib import Path
from typing import Annotated

import typer

from boom_mj.cli.arguments import Hinges, find_machine, output_path
from boom_mj.errors import InputError
from boom_mj.logs import load_topic_map, read_log, write_mcap
from boom_mj.sensors import Replay, boom_scene, replay
from boom_mj.simulation import make_plant


def command(
    log: Annotated[Path, typer.Argument(metavar="LOG", help="MCAP log, ROS bag or CSV table.")],
    machine: Annotated[str | None, typer.Option(help="Machine file or name; the log's own if left out.")] = None,
    topic_map: Annotated[
        Path | None,
        typer.Option("--map", metavar="MAP.toml", help="What feeds which signal; `logs inspect` proposes one."),
    ] = None,
    output: Annotated[Path | None, typer.Option("-o", metavar="OUT.mcap", help="Where the twin goes.")] = None,
    picture: Annotated[Path | None, typer.Option(metavar="PNG", help="Log and twin overlaid.")] = None,
    hinges: Hinges = 1,
    as_json: Annotated[bool, typer.Option("--json", help="One JSON document on stdout.")] = False,
) -> None:
    """Drive the model with a log's joint angles and known load, and compare every channel group with its noise.

    The angles are smoothed: held at their mean where the joint rests, by a spline of locally even jerk between.
    """
    for path, suffix in ((output, ".mcap"), (picture, ".png")):
        if path is not None:
            output_path(path, suffix)
    if not log.exists():
        raise InputError(f"{log}: there is no such log")
    recording = read_log(log, None if topic_map is None else load_topic_map(topic_map))
    if machine is None and not recording.machine:
        raise InputError(f"{log}: the log does not name its machine; say which with --machine")
    result = replay(make_plant(find_machine(machine or recording.machine), hinges), recording)
    if output is not None:
        scene = boom_scene(result.trajectory, recording["joint/position"].time[0])
        write_mcap(result.twin, output, beside={"/measured": result.log}, scene=scene)
    if picture is not None:
        from boom_mj.report import draw_overlay

        draw_overlay(result, picture)
    print(json.dumps(_document(result), indent=1) if as_json else _table(result))
    for path in (output, picture):
        if path is not None:
            print(f"wrote {path}", file=sys.stderr)


def _document(result: Replay) -> dict:
    groups = {g.name: {"rms": g.rms, "noise": g.noise, "ratio": g.ratio, "unit": g.unit} for g in result.groups}
    steps = len(result.trajectory.time)
    simulated = float(result.trajectory.time[-1])
    timing = {"simulated_s": simulated, "steps": steps, "loop_wall_s": result.loop_wall_s}
    return {"log": result.log.name, "machine": result.twin.machine, "groups": groups, "timing": timing}


def _table(result: Replay) -> str:
    """Sensors down, directions across; every entry in units of the sensor's noise."""
    lines = [f"{result.log.name}: rms(measured - simulated) / sensor noise"]
    rows: dict[str, dict[str, str]] = {}
    for group in result.groups:
        stem, _, axis = group.name.rpartition("/") if group.name[-2:-1] == "/" else (group.name, "", "x")
        rows.setdefault(stem, {})[axis] = f"{group.ratio:9.2f}"
    width = max(map(len, rows), default=0)
    lines.append(f"{'':{width}}{'x':>9}{'y':>9}{'z':>9}")
    lines += [f"{stem:{width}}" + "".join(row.get(axis, "") for axis in "xyz") for stem, row in rows.items()]
    return "\n".join(lines)
