"""gap discover: the law that no library has."""

import json
from pathlib import Path
from typing import Annotated, Any

import typer

from boom_mj.cli.arguments import (
    AnswerFile,
    AnswerPage,
    ChannelMapFile,
    EffectFiles,
    LogsMachine,
    ModelFile,
    Seconds,
    output_path,
    printable,
    stopwatch,
)
from boom_mj.cli.gap_data import load_gap_data
from boom_mj.errors import InputError
from boom_mj.files import write_text


def command(
    logs: Annotated[list[Path], typer.Argument(metavar="LOGS...", help="Training logs.")],
    holdout: Annotated[
        list[Path] | None,
        typer.Option(metavar="LOGS...", help="Held-out logs; without any, logs are split in time."),
    ] = None,
    machine: LogsMachine = None,
    as_json: AnswerFile = None,
    html: AnswerPage = None,
    output: Annotated[
        Path | None, typer.Option("-o", metavar="LAW.py", help="The law as an effect that --effects takes.")
    ] = None,
    without: Annotated[
        list[str] | None,
        typer.Option(metavar="ID", help="Effect of the library that a law may stand for; several may be given."),
    ] = None,
    forces: Annotated[
        bool, typer.Option(help="Estimate forces in time, without a formula, even where the gap is explained.")
    ] = False,
    channels: ChannelMapFile = None,
    model: ModelFile = None,
    seconds: Seconds = None,
    own_effects: EffectFiles = None,
) -> None:
    """Find the law behind a gap that no effect of the library closes: a formula at one place, with units and intervals.

    Example: python -m boom_mj gap discover a.mcap b.mcap --holdout c.mcap -o law.py --html law.html
    """
    from boom_mj.diagnosis.clock import Clock
    from boom_mj.discovery import discover, document, law_file
    from boom_mj.effects import effect_library
    from boom_mj.systems.predictor import Predictor

    table = None if as_json in (None, "-") else Path(str(as_json))
    for path, suffix in ((html, ".html"), (output, ".py"), (table, None)):
        if path is not None:
            output_path(path, suffix)
    if output is not None and not output.stem.isidentifier():
        raise InputError(f"{output}: the file's name is the law's id; it should be a Python name such as law.py")
    if output is not None and output.stem in effect_library():
        raise InputError(f"{output}: the library has an effect {output.stem} already; give the law another name")
    for name in without or ():
        if name not in effect_library():
            raise InputError(f"--without {name}: the library holds {', '.join(effect_library())}")
    tell = stopwatch()
    given = load_gap_data(logs, holdout or [], machine, channels, model)
    for finding in given.findings:
        tell(printable(finding.sentence))
    found = discover(Predictor(given.system, given.data), tuple(without or ()), Clock(seconds, tell), forces)
    answer = document(found, given.names, given.findings)
    text = json.dumps(answer, indent=1)
    try:
        if table is not None:
            write_text(table, text)
        if html is not None:
            from boom_mj.report import write_discovery

            write_discovery(found, given.names, html, given.findings)
        if output is not None and found.verdict == "law":
            write_text(output, law_file(found, output.stem))
        elif output is not None:
            tell(f"{output} is not written: there is no law")
    finally:  # a full disk does not cost the answer
        print(text if as_json == "-" else _summary(answer))


def _summary(answer: dict[str, Any]) -> str:
    from boom_mj.effects import behind

    lines = [f"{answer['verdict']}: {answer['sentence']}", ""]
    if answer["law"]:
        lines.append(f"  {answer['law']['formula']}   on {answer['law']['acts_on']}")
        for name, p in answer["law"]["parameters"].items():
            size = f"{p['value']:z.4g}{behind(p['unit'])}"
            lines.append(f"      {name:16} {size}   95 %: {p['low']:z.4g} .. {p['high']:z.4g}")
    for part, gaps in (("training", answer["gap"]["train"]), ("held out", answer["gap"]["holdout"])):
        lines.append(f"  gap {part:9} {gaps['before']:7.2f} -> {gaps['after']:.2f}   (floor 1)")
    for row in answer["front"]:
        lines.append(
            f"  {len(row['terms'])} terms leave {row['holdout_gap']:.2f}: {row['formula']}, on {row['acts_on']}"
        )
    for force in [force for force in answer["forces"] if force["closure"] > 0][:3]:
        low, high = force["closure_interval"]
        lines.append(
            f"  a force in time on {force['acts_on']} closes {force['closure']:.0%}   95 %: {low:.0%} .. {high:.0%}"
        )
    for what in answer["skipped"][:4]:
        lines.append(f"  not looked at for want of time: {what}")
    return "\n".join(lines)
