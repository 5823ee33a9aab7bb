"""replay: the joint angles of a log drive the model."""

import gc
import json
import math
import sys
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from boom_mj.cli.arguments import AsJson, EffectFiles, Hinges, find_machine, last_states_beside, output_path
from boom_mj.errors import InputError

if TYPE_CHECKING:
    from boom_mj.replay import Replay
    from boom_mj.replay.quality import Quality


def command(
    log: Annotated[Path, typer.Argument(metavar="LOG", help="MCAP log, ROS bag or CSV table.")],
    machine: Annotated[str | None, typer.Option(help="Machine file or name; the log's own if left out.")] = None,
    topic_map: Annotated[
        Path | None,
        typer.Option("--map", metavar="MAP.toml", help="What feeds which signal; `logs inspect` proposes one."),
    ] = None,
    output: Annotated[
        Path | None,
        typer.Option("-o", metavar="OUT.mcap", help="Simulated recording to write, beside what was measured."),
    ] = None,
    picture: Annotated[
        Path | None, typer.Option(metavar="PNG", help="Picture to draw: log and simulation overlaid.")
    ] = None,
    with_residual: Annotated[
        bool, typer.Option("--residual", help="With measured - simulated, beside both, in OUT.mcap.")
    ] = False,
    hinges: Hinges = 1,
    as_json: AsJson = False,
    own_effects: EffectFiles = None,
) -> None:
    """Drive the model with a log's joint angles and known load, and compare every channel group with its noise.

    First comes what the log is good for, on stderr: what moves, rates against the first modes, noise against the
    machine file, gaps. The angles are smoothed: held at their mean where the joint rests, by a spline of locally even
    jerk between.

    Example: python -m boom_mj replay log.mcap --hinges 4 -o simulated.mcap --picture replay.png
    """
    from boom_mj.logs import load_topic_map, read_log
    from boom_mj.replay import replay
    from boom_mj.replay.quality import assess
    from boom_mj.simulation import make_plant

    for path, suffix in ((output, ".mcap"), (picture, ".png")):
        if path is not None:
            output_path(path, suffix)
    if not log.exists():
        raise InputError(f"{log}: there is no such log")
    recording = read_log(log, None if topic_map is None else load_topic_map(topic_map))
    if machine is None and not recording.machine:
        raise InputError(f"{log}: the log does not name its machine; say which with --machine")
    plant = make_plant(find_machine(machine or recording.machine), hinges)
    quality = assess(plant, recording)
    print(f"{recording.name}: {quality.summary()}", file=sys.stderr)
    for remark in quality.remarks():
        print(f"warning: {remark}", file=sys.stderr)
    with _uncollected(), ThreadPoolExecutor(1) as worker:  # works while MuJoCo computes, and while the picture is drawn
        if picture is not None:
            worker.submit(import_module, "boom_mj.report.overlay")
        with last_states_beside(output):
            result = replay(plant, recording)
        writing = None if output is None else worker.submit(_write, result, output, with_residual)
        if picture is not None:
            from boom_mj.report import draw_overlay

            draw_overlay(result, picture)
        if writing is not None:
            writing.result()
    print(json.dumps(_document(result, quality, hinges), indent=1) if as_json else _table(result))
    for path in (output, picture):
        if path is not None:
            print(f"wrote {path}", file=sys.stderr)


def _write(result: "Replay", path: Path, with_residual: bool) -> None:
    """The simulated recording beside what was measured."""
    from boom_mj.logs import write_mcap
    from boom_mj.replay import residual
    from boom_mj.sensors import boom_scene

    beside = {"/measured": result.log}
    if with_residual:
        beside["/residual"] = residual(result.log, result.twin)
    scene = boom_scene(result.trajectory, result.log["joint/position"].time[0])
    write_mcap(result.twin, path, beside=beside, scene=scene)


@contextmanager
def _uncollected() -> Iterator[None]:
    """No garbage collection: while a picture grows it would walk over all modules again and again, and find nothing."""
    gc.disable()
    try:
        yield
    finally:
        gc.enable()


def _document(result: "Replay", quality: "Quality", hinges: int) -> dict:
    groups = {g.name: {"rms": g.rms, "noise": g.noise, "ratio": g.ratio, "unit": g.unit} for g in result.groups}
    steps = len(result.trajectory.time)
    simulated = float(result.trajectory.time[-1])
    timing = {"simulated_s": simulated, "steps": steps, "loop_wall_s": result.loop_wall_s}
    names = {"log": result.log.name, "machine": result.twin.machine, "hinges": hinges}
    return {**names, "groups": groups, "timing": timing, "quality": _quality(quality)}


def _quality(quality: "Quality") -> dict:
    """Rates and gaps by signal, noise and excitation by channel; noise is null where a channel has no samples."""
    signals = {
        s.name: {
            "rate_hz": s.rate_hz,
            "samples_per_period": s.samples_per_period,
            "missing": s.missing,
            "longest_gap_s": s.longest_gap,
            "longest_gap_at_s": s.longest_gap_at,
            "channels": {
                c.name: {
                    "noise": None if math.isnan(c.noise) else c.noise,
                    "expected_noise": c.expected_noise,
                    "excitation": c.excitation,
                }
                for c in s.channels
            },
        }
        for s in quality.signals
    }
    return {"modes_hz": quality.modes_hz, "remarks": quality.remarks(), "signals": signals}


def _table(result: "Replay") -> str:
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
