"""calibrate: recordings to a machine file whose masses, stiffness and damping fit them."""

import json
import sys
import time
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from boom_mj.cli.arguments import MachineFile, begins_afresh, find_machine, machine_text, output_path
from boom_mj.errors import InputError
from boom_mj.files import write_text

if TYPE_CHECKING:
    from boom_mj.calibration import Plan


def command(
    machine: MachineFile,
    logs: Annotated[list[Path], typer.Argument(metavar="LOGS...", help="Logs of the machine.")],
    output: Annotated[
        Path | None, typer.Option("-o", metavar="CALIBRATED.toml", help="Machine file with the calibrated values.")
    ] = None,
    as_json: Annotated[str | None, typer.Option("--json", metavar="FILE", help="Answer as JSON; - for stdout.")] = None,
    html: Annotated[Path | None, typer.Option(metavar="FILE", help="Answer as a page with pictures.")] = None,
    free: Annotated[
        list[str] | None,
        typer.Option(metavar="KIND", help="Kind of parameter that may move, such as mass; several may be given."),
    ] = None,
    holdout: Annotated[
        list[Path] | None, typer.Option(metavar="LOGS...", help="Logs to validate by; they do not train.")
    ] = None,
    plan: Annotated[bool, typer.Option("--plan", help="Only say which experiment to record next.")] = False,
) -> None:
    """Fit masses, stiffness and damping to logs, with intervals; joint zero offsets are estimated along.

    First steps that need no simulation - masses by forces at rest, stiffness by falls and frequencies after a load is
    cut, damping by decays -, then all recordings at once. What the logs cannot tell stays as the file has it, and is
    named.

    Example: python -m boom_mj calibrate boom36 release_bow_vertical.mcap slew_t.mcap -o calibrated.toml
    """
    from boom_mj.calibration import (
        KINDS,
        USUAL,
        calibrate,
        calibrated_text,
        document,
        plan_next,
        validate,
        validation_document,
    )
    from boom_mj.logs import read_log

    for path, suffix in (
        (html, ".html"),
        (output, ".toml"),
        (None if as_json in (None, "-") else Path(str(as_json)), None),
    ):
        if path is not None:
            output_path(path, suffix)
    for kind in free or ():
        if kind not in KINDS:
            raise InputError(f"--free {kind}: there are {', '.join(KINDS)}")
    boom = find_machine(machine)
    for log in (*logs, *(holdout or ())):
        if not log.exists():
            raise InputError(f"{log}: there is no such log")
    recordings, unseen = [read_log(path) for path in logs], [read_log(path) for path in holdout or ()]
    began = time.perf_counter()

    def tell(line: str) -> None:
        print(f"{time.perf_counter() - began:6.1f} s  {line}", file=sys.stderr, flush=True)

    tell(begins_afresh())
    kinds, names = tuple(free or USUAL), [str(path) for path in logs]
    if plan:
        proposed = plan_next(boom, recordings, kinds, tell=tell)
        answer = {"sentence": proposed.sentence, **asdict(proposed)}
        _write(as_json, answer)
        print(json.dumps(answer, indent=1) if as_json == "-" else _proposals(proposed))
        return
    found = calibrate(boom, recordings, kinds, tell=tell)
    shown = validate(found, unseen)
    answer = {**document(found, names), "validation": validation_document(shown)}
    try:
        _write(as_json, answer)
        if output is not None:
            write_text(output, calibrated_text(machine_text(machine), found))
        if html is not None:
            from boom_mj.report import write_calibration

            write_calibration(shown, names, html)
    finally:  # a full disk does not cost the answer
        print(json.dumps(answer, indent=1) if as_json == "-" else _summary(answer))


def _write(path: str | None, answer: dict[str, Any]) -> None:
    if path not in (None, "-"):
        write_text(str(path), json.dumps(answer, indent=1))


def _proposals(found: "Plan") -> str:
    lines = [found.sentence, "", f"  {'experiment':34}{'s':>5}   {found.parameter} known to"]
    lines += [f"  {p.experiment:34}{p.duration:5.0f}   {100 * p.after:.2g} %" for p in found.proposals]
    return "\n".join(lines)


def _summary(answer: dict[str, Any]) -> str:
    lines = [answer["sentence"], ""]
    for p in answer["parameters"]:
        interval = "held" if p["held"] else f"{p['low']:.4g} .. {p['high']:.4g}"
        lines.append(f"  {p['name']:26}{p['value']:12.5g} {p['unit']:3} x {p['factor']:.4f}   95 %: {interval}")
    for k, offset in enumerate(answer["zero_offsets_deg"]):
        lines.append(
            f"  joint{k + 1} zero offset         {offset['value']:12.3f} deg          "
            f"95 %: {offset['low']:.3f} .. {offset['high']:.3f}"
        )
    known = answer["identifiability"]
    lines.append(f"  rank {known['rank']} of {known['of']}, condition {known['condition'] or float('inf'):.3g}")
    for one, other, value in known["correlated"][:5]:
        lines.append(f"  {one} and {other} are correlated by {value:+.3f}")
    gap = answer["gap"]
    for row in answer["validation"]["experiments"]:
        said = [
            f"{what} {100 * row[key]['error']['uncalibrated']:+.2f} -> {100 * row[key]['error']['calibrated']:+.2f} %"
            for what, key in (("fall", "fall_m"), ("first frequency", "frequency_hz"))
            if key in row
        ]
        lines.append(f"  {row['name']}{' (held out)' if row['held_out'] else ''}: {', '.join(said)}")
    lines.append(f"  gap {gap['before']:.2f} -> {gap['after']:.2f} (floor 1)")
    return "\n".join(lines)
