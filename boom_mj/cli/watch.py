"""gap watch: since when is a machine no longer what it was, and what changed."""

import json
from pathlib import Path
from typing import Annotated, Any

import typer

from boom_mj.cli.arguments import (
    AnswerFile,
    ChannelMapFile,
    EffectFiles,
    LogsMachine,
    ModelFile,
    Seconds,
    begins_afresh,
    check_machine,
    find_machine,
    output_path,
    printable,
    stopwatch,
)
from boom_mj.errors import InputError
from boom_mj.files import write_text


def command(
    logs: Annotated[list[Path], typer.Argument(metavar="LOGS...", help="Logs in the order of their time.")],
    healthy: Annotated[
        list[Path],
        typer.Option(metavar="LOGS...", help="Logs of the machine when it was well."),
    ],
    machine: LogsMachine = None,
    channels: ChannelMapFile = None,
    model: ModelFile = None,
    picture: Annotated[
        Path | None, typer.Option(metavar="PNG", help="Picture: every log, and sizes over logs.")
    ] = None,
    as_json: AnswerFile = None,
    seconds: Seconds = None,
    own_effects: EffectFiles = None,
) -> None:
    """Say of every log whether the machine is still what it was, since when it is not, and what changed.

    Example: python -m boom_mj gap watch monday.mcap tuesday.mcap --healthy first.mcap second.mcap
    """
    from boom_mj.diagnosis.clock import Clock
    from boom_mj.diagnosis.sentences import sentence
    from boom_mj.diagnosis.watch import watch
    from boom_mj.logs import read_log
    from boom_mj.systems.boom import BoomSystem
    from boom_mj.systems.mjcf import load_mjcf
    from boom_mj.systems.system import System

    check_machine(machine, channels, model)
    table = None if as_json in (None, "-") else output_path(Path(str(as_json)))
    if picture is not None:
        output_path(picture, ".png")
    tell = stopwatch()
    tell(begins_afresh())
    system: System
    if channels is not None:
        given = load_mjcf(healthy, logs, channels, model)
        for finding in given.findings:
            tell(printable(finding.sentence))
        system, recordings, training = given.system, given.data.recordings, given.data.training
        well, later = list(recordings[:training]), list(recordings[training:])
    else:
        well, later = ([read_log(path) for path in paths] for paths in (healthy, logs))
        names = {log.machine for log in (*well, *later) if log.machine}
        if machine is None and len(names) != 1:
            told = "their machine" if not names else f"one machine: {', '.join(sorted(names))}"
            raise InputError(f"the logs do not name {told}; say which with --machine")
        system = BoomSystem(find_machine(machine or names.pop()))
    found = watch(system, well, later, Clock(seconds, tell))
    answer = found.document()
    text = json.dumps(answer, indent=1)
    try:
        if table is not None:
            write_text(table, text)
        if picture is not None:
            from boom_mj.report import draw_watch

            draw_watch(answer, picture)
    finally:  # a full disk does not cost the answer
        print(text if as_json == "-" else _summary(answer, sentence(found.found) if found.found else ""))


def _summary(answer: dict[str, Any], words: str) -> str:
    width = max(len(row["log"]) for row in answer["logs"])
    lines = [
        f"{row['log']:{width}}  {'changed' if row['changed'] else 'as it was':9}  "
        f"{row['statistic']:8.1f} of {row['limit']:.1f}  {row['group'] if row['changed'] else ''}"
        for row in answer["logs"]
    ]
    if answer["since"] is None:
        return "\n".join([*lines, "", "The machine is what it was."])
    since = f"Changed since {answer['since']['time_s']:.0f} s of {answer['since']['log']}."
    return "\n".join([*lines, "", since, f"{answer['verdict']}: {words}", *_sizes(answer["logs"])])


def _sizes(logs: list[dict[str, Any]]) -> list[str]:
    """How large every cause is in every log by itself, with its 95 % interval."""
    from boom_mj.effects import behind
    from boom_mj.report.words import effect_name

    lines = []
    for k, cause in enumerate(logs[0]["effects"]):
        for name in cause["parameters"]:
            lines += ["", f"{effect_name(cause)}, {name} in each log by itself:"]
            for row in logs:
                if not row["effects"]:
                    lines.append(f"{row['log']}  not looked at for want of time")
                    continue
                size = row["effects"][k]["parameters"][name]
                value, low, high = ("inf" if size[e] is None else f"{size[e]:z.4g}" for e in ("value", "low", "high"))
                lines.append(f"{row['log']}  {value} ({low} to {high}){behind(size['unit'])}")
    return lines
