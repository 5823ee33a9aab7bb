"""gap: where simulator and machine disagree, which effect causes it, how far the gap shrinks."""

import inspect
import json
import sys
import time
from pathlib import Path
from typing import Annotated, Any

import typer

from boom_mj.cli import blind
from boom_mj.cli.arguments import ManyHoldouts, find_machine, machine_text, output_folder, output_path
from boom_mj.effects import effect_library
from boom_mj.effects.general_effect import general_library
from boom_mj.errors import InputError
from boom_mj.files import locked, write_text
from boom_mj.logs import read_log, write_mcap
from boom_mj.logs.columns import write_columns
from boom_mj.recording import Recording, named_signal

app = typer.Typer(help="Diagnose the gap between simulator and machine.", no_args_is_help=True)
app.add_typer(blind.app, name="blind")


@app.command()
def effects() -> None:
    """List the effect library: physics, parameters, what each is confused with, which experiment tells.

    Example: python -m boom_mj gap effects
    """
    for kind in effect_library().values():
        places = ", ".join(f"{key} = {'|'.join(map(str, choices))}" for key, choices in kind.places.items())
        print(f"{kind.id}{f'  ({places})' if places else ''}")
        print("    " + (inspect.getdoc(kind) or "").replace("\n", "\n    "))
        for name, knob in kind.parameters.items():
            print(f"    - {name}: {knob.unit}, neutral {knob.neutral:g}, from {knob.low:g} to {knob.high:g}")
        print(f"    confused with: {', '.join(kind.confused_with) or 'nothing known'}; told by: {kind.told_by}\n")
    print("Of any MJCF machine (--map); sizes and places come from the model and its logs:\n")
    for general in general_library().values():
        print(f"{general.id}  ({general.where or 'the whole machine'})")
        print("    " + (inspect.getdoc(general) or "").replace("\n", "\n    "))
        print(f"    confused with: {', '.join(general.confused_with)}; told by: {general.told_by}\n")


@app.command(cls=ManyHoldouts)
def diagnose(
    logs: Annotated[list[Path], typer.Argument(metavar="LOGS...", help="Logs to learn from.")],
    holdout: Annotated[
        list[Path] | None,
        typer.Option(
            metavar="LOGS...",
            help="Logs to judge by (one's rest if its start must be learnt from); without any, logs are split in time.",
        ),
    ] = None,
    machine: Annotated[str | None, typer.Option(help="Machine file or name; the logs' own if left out.")] = None,
    as_json: Annotated[str | None, typer.Option("--json", metavar="FILE", help="Answer as JSON; - for stdout.")] = None,
    html: Annotated[Path | None, typer.Option(metavar="FILE", help="Answer as a page with pictures.")] = None,
    output: Annotated[
        Path | None, typer.Option("-o", metavar="CORRECTED.toml", help="Machine file with the effects in it.")
    ] = None,
    predictions: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="Nominal and corrected twin of every log, as MCAP; as CSV with --map."),
    ] = None,
    without: Annotated[
        list[str] | None, typer.Option(metavar="ID", help="Effect to leave out of the library; several may be given.")
    ] = None,
    channels: Annotated[
        Path | None,
        typer.Option("--map", metavar="MAP.toml", help="Any machine: what the fields of its logs are."),
    ] = None,
    model: Annotated[
        Path | None, typer.Option(metavar="MODEL.xml", help="Its MJCF file; the map's if left out.")
    ] = None,
) -> None:
    """Say where simulator and logs disagree, which effect causes it, and how far the gap shrinks on held-out logs.

    Example: python -m boom_mj gap diagnose a.mcap b.mcap --holdout c.mcap --html gap.html -o corrected.toml
    """
    from boom_mj.diagnosis import Campaign, document, with_effects_text
    from boom_mj.diagnosis import diagnose as find

    if model is not None and channels is None:
        raise InputError("--model needs a channel map: say which field of the log is what with --map MAP.toml")
    if channels is not None and machine is not None:
        raise InputError("--machine goes with booms only; with --map the model is --model MODEL.xml")
    table = None if as_json in (None, "-") else Path(str(as_json))
    for path, suffix in ((html, ".html"), (output, ".xml" if channels else ".toml"), (table, None)):
        if path is not None:
            output_path(path, suffix)
    if predictions is not None:
        output_folder(predictions)
    for name in without or ():
        known = general_library() if channels else effect_library()
        if name not in known:
            raise InputError(f"--without {name}: the library holds {', '.join(known)}")
    paths = [*logs, *(holdout or ())]
    recordings = [] if channels else [read_log(path) for path in paths]
    began = time.perf_counter()

    def tell(line: str) -> None:
        print(f"{time.perf_counter() - began:6.1f} s  {line}", file=sys.stderr)

    if channels is not None:
        from boom_mj.systems.mjcf import corrected_model, robot_campaign

        campaign = robot_campaign(logs, holdout or (), channels, model)
        names = [log.name for log in campaign.recordings]
    else:
        name = machine or recordings[0].machine
        if not name:
            raise InputError(f"{paths[0]}: the log does not name its machine; say which with --machine")
        campaign = Campaign(find_machine(name), recordings, len(logs))
        names = [str(path) for path in paths]
    found = find(campaign, tuple(without or ()), tell)
    answer = document(found, names)
    tell(answer["verdict"])
    text = json.dumps(answer, indent=1)
    if table is not None:
        write_text(table, text)
    if output is not None:
        write_text(output, corrected_model(found) if channels else with_effects_text(machine_text(name), found))
    if predictions is not None:
        with locked(predictions):
            _write_predictions(found, predictions, paths)
    if html is not None:
        from boom_mj.report import write_diagnosis

        write_diagnosis(found, names, html)
    print(text if as_json == "-" else _summary(answer))


def _summary(answer: dict[str, Any]) -> str:
    lines = [f"{answer['verdict']}: {answer['sentence']}", ""]
    for effect in answer["effects"] or answer["suspect"]:
        lines.append(f"  {_named(effect)}")
        for name, p in effect["parameters"].items():
            interval = " .. ".join("inf" if p[end] is None else f"{p[end]:.4g}" for end in ("low", "high"))
            size = f"{p['value']:.4g} {p['unit']}".removesuffix(" 1")
            lines.append(f"      {name:16} {size}   95 %: {interval}")
    for part, gaps in (("training", answer["gap"]["train"]), ("held out", answer["gap"]["holdout"])):
        lines.append(f"  gap {part:9} {gaps['before']:7.2f} -> {gaps['after']:.2f}   (floor 1)")
    for rival in answer["rivals"][:4]:
        lines.append(f"  not {' + '.join(map(_named, (rival, *rival.get('with', ()))))}: {rival['why_not']}")
    if answer["next_experiment"]:
        lines.append(f"  next experiment: {answer['next_experiment']}")
    return "\n".join(lines)


def _named(effect: dict[str, Any]) -> str:
    return " ".join([effect["id"], *(f"{k} {v}" for k, v in effect["location"].items())])


def _write_predictions(found: Any, folder: Path, paths: list[Path]) -> None:
    from boom_mj.diagnosis import twins
    from boom_mj.systems.mjcf import MjcfSystem, twin_tables

    folder.mkdir(parents=True, exist_ok=True)
    campaign, stems = found.metric.campaign, _stems(paths)
    for kind in ("nominal", "corrected"):
        said = twins(found, kind == "corrected")
        if isinstance(campaign.subject, MjcfSystem):
            for log_path, table in twin_tables(campaign, said).items():
                write_columns(folder / f"{stems[Path(log_path)]}.{kind}.csv", table)
            continue
        for log, path, twin in zip(campaign.recordings, paths, said):
            signals = {name: named_signal(name, log[name].time, values) for name, values in twin.items()}
            recording = Recording(log.name, log.machine, f"{kind} twin: {log.description}", signals)
            write_mcap(recording, folder / f"{stems[path]}.{kind}.mcap")


def _stems(paths: list[Path]) -> dict[Path, str]:
    """File names without endings, numbered where they are alike."""
    stems: dict[Path, str] = {}
    for path in dict.fromkeys(paths):
        stem = Path(path.name.removesuffix(".gz")).stem
        alike = sum(taken.rpartition("-")[0] == stem or taken == stem for taken in stems.values())
        stems[path] = f"{stem}-{alike + 1}" if alike else stem
    return stems
