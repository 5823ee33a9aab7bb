"""gap: where simulator and machine disagree, which effect causes it, how far the gap shrinks."""

import inspect
import json
import math
from pathlib import Path
from typing import Annotated, Any

import typer

from boom_mj.cli import blind, design, discover, watch
from boom_mj.cli.arguments import (
    AnswerFile,
    AnswerPage,
    AsJson,
    ChannelMapFile,
    EffectFiles,
    LogsMachine,
    ModelFile,
    Most,
    Seconds,
    begins_afresh,
    output_folder,
    output_path,
    printable,
    stopwatch,
)
from boom_mj.cli.gap_data import load_gap_data
from boom_mj.cli.many_logs import ManyLogs
from boom_mj.errors import InputError, OutputError
from boom_mj.files import locked, write_text

app = typer.Typer(help="Diagnose the gap between simulator and machine.", no_args_is_help=True)
app.add_typer(blind.app, name="blind")
app.command("watch", cls=ManyLogs)(watch.command)
app.command("discover", cls=ManyLogs)(discover.command)
app.command("design")(design.command)


@app.command()
def effects(own_effects: EffectFiles = None, as_json: AsJson = False) -> None:
    """List the effect library: physics, parameters, what each is confused with, which experiment tells.

    Example: python -m boom_mj gap effects
    """
    from boom_mj.effects import BOOM_SITES, effect_library

    if as_json:
        print(json.dumps({"effects": [_described(kind) for kind in effect_library().values()]}, indent=1))
        return
    for kind in effect_library().values():
        sites = kind.allowed(BOOM_SITES)
        choices = {key: dict.fromkeys(site.location[key] for site in sites if key in site.location) for key in kind.at}
        places = ", ".join(f"{key} = {'|'.join(map(str, names))}" if names else key for key, names in choices.items())
        print(f"{kind.id}  ({places or 'the whole machine'})")
        print("    " + (inspect.getdoc(kind) or "").replace("\n", "\n    "))
        for name, parameter in kind.parameters(sites[0]).items() if sites else ():
            span = f"from {parameter.low:g} to {parameter.high:g}"
            print(f"    - {name}: {parameter.unit}, neutral {parameter.neutral:g}, {span}")
        if not sites:
            print("    of any MJCF machine (--map); sizes and places come from the model and its logs")
        alike = ", ".join(kind.confused_with) or "nothing known"
        print(f"    confused with: {alike}; told apart by: {kind.separating_experiment}\n")


def _described(kind: Any) -> dict[str, Any]:
    """An effect as plain data; what depends on the site of an MJCF machine is left out."""
    from boom_mj.effects import BOOM_SITES

    sites = kind.allowed(BOOM_SITES)
    declared = kind.parameters(sites[0]) if sites else {}
    return {
        "id": kind.id,
        "physics": inspect.getdoc(kind) or "",
        "locations": [site.location for site in sites],
        "at": list(kind.at),
        "needs": sorted(kind.needs),
        "parameters": {name: _bounds(parameter) for name, parameter in declared.items()},
        "confused_with": list(kind.confused_with),
        "separating_experiment": kind.separating_experiment,
    }


def _bounds(parameter: Any) -> dict[str, Any]:
    ends = {"neutral": parameter.neutral, "low": parameter.low, "high": parameter.high}
    return {"unit": parameter.unit, **{name: value if math.isfinite(value) else None for name, value in ends.items()}}


@app.command()
def criteria(as_json: AsJson = False) -> None:
    """List every number that decides about an answer, with its unit and its reason.

    Example: python -m boom_mj gap criteria
    """
    from boom_mj.diagnosis.criteria import described

    if as_json:
        rows = [
            {"family": family, "name": f.name, **f.metadata, "value": {kind: _finite(v) for kind, v in values.items()}}
            for family, f, values in described()
        ]
        print(json.dumps({"criteria": rows}, indent=1))
        return
    for family, field, values in described():
        one = dict.fromkeys(f"{value:g}" for value in values.values())
        shown = next(iter(one)) if len(one) == 1 else ", ".join(f"{kind} {v:g}" for kind, v in values.items())
        print(f"{family:9} {field.name:18} {shown} {field.metadata['unit']}: {field.metadata['reason']}")


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None


@app.command(cls=ManyLogs)
def diagnose(
    logs: Annotated[list[Path], typer.Argument(metavar="LOGS...", help="Training logs.")],
    holdout: Annotated[
        list[Path] | None,
        typer.Option(
            metavar="LOGS...",
            help="Held-out logs (one's start trains if no other shows its gap); without any, logs are split in time.",
        ),
    ] = None,
    machine: LogsMachine = None,
    as_json: AnswerFile = None,
    html: AnswerPage = None,
    output: Annotated[
        Path | None,
        typer.Option("-o", metavar="CORRECTED.toml", help="Machine file with the effects of the answer in it."),
    ] = None,
    nuisances: Annotated[
        bool, typer.Option("--as-built", help="Write the nuisances that were estimated along into -o, too.")
    ] = False,
    predictions: Annotated[
        Path | None,
        typer.Option(
            metavar="DIR", help="Nominal, as built, corrected simulation of every log, as MCAP; as CSV with --map."
        ),
    ] = None,
    without: Annotated[
        list[str] | None, typer.Option(metavar="ID", help="Effect to leave out of the library; several may be given.")
    ] = None,
    channels: ChannelMapFile = None,
    model: ModelFile = None,
    healthy: Annotated[
        list[Path] | None,
        typer.Option(metavar="LOGS...", help="Logs of the machine when it was well: what changed since is diagnosed."),
    ] = None,
    most: Most = None,
    seconds: Seconds = None,
    strict: Annotated[
        bool, typer.Option("--strict", help="Refuse logs with which anything is wrong, instead of using what is sound.")
    ] = False,
    own_effects: EffectFiles = None,
) -> None:
    """Say where simulator and logs disagree, which effect causes it, and how far the gap shrinks on held-out logs.

    Example: python -m boom_mj gap diagnose a.mcap b.mcap --holdout c.mcap --html gap.html -o corrected.toml
    """
    from boom_mj.diagnosis import Diagnosis, built_with, causes, channel_steps, document, reasons
    from boom_mj.diagnosis import diagnose as find
    from boom_mj.diagnosis.clock import Clock
    from boom_mj.effects import effect_library
    from boom_mj.systems.predictor import Predictor
    from boom_mj.systems.system import Corrects

    table = None if as_json in (None, "-") else Path(str(as_json))
    for path, suffix in ((html, ".html"), (output, ".xml" if channels else ".toml"), (table, None)):
        if path is not None:
            output_path(path, suffix)
    if nuisances and output is None:
        raise InputError("--as-built says what -o FILE shall hold; name the file with -o")
    if predictions is not None:
        output_folder(predictions)
    for name in without or ():
        if name not in effect_library():
            raise InputError(f"--without {name}: the library holds {', '.join(effect_library())}")
    paths, tell = [*logs, *(holdout or ())], stopwatch()
    tell(begins_afresh(table))
    given = load_gap_data(logs, holdout or [], machine, channels, model, healthy or [], strict, tell)
    system, data, names, findings = given.system, given.data, given.names, given.findings
    for finding in findings:
        tell(printable(finding.sentence))
    clock = Clock(seconds, tell)

    def keep(so_far: Diagnosis) -> None:
        if table is not None:
            try:
                write_text(table, json.dumps({**document(so_far, names, findings), "complete": False}, indent=1))
            except OutputError as error:  # there may be room when all is done
                tell(f"the best so far is not kept: {error}")

    found = find(Predictor(system, data), tuple(without or ()), clock, most, keep)
    answer = document(found, names, findings, channel_steps(found, names))
    tell(answer["verdict"])
    text = json.dumps(answer, indent=1)
    try:
        if table is not None:
            write_text(table, text)
        if output is not None and isinstance(system, Corrects):
            write_text(output, system.corrected(causes(found), built_with(found) if nuisances else (), reasons(found)))
        if predictions is not None:
            with locked(predictions):
                _write_predictions(found, predictions, paths if channels else list(map(Path, names)))
        if html is not None:
            from boom_mj.report import write_diagnosis

            write_diagnosis(found, answer, html)
    finally:  # a full disk does not cost the answer
        print(text if as_json == "-" else _summary(answer))


def _summary(answer: dict[str, Any]) -> str:
    from boom_mj.effects import behind

    lines = [f"{answer['verdict']}: {answer['sentence']}", ""]
    suspects = [("suspect ", effect) for effect in answer["suspect"]]
    for kind, effect in (*(("", effect) for effect in answer["effects"]), *suspects):
        lines.append(f"  {kind}{_named(effect)}")
        for name, p in effect["parameters"].items():
            interval = " .. ".join("inf" if p[end] is None else f"{p[end]:z.4g}" for end in ("low", "high"))
            size = f"{p['value']:z.4g}{behind(p['unit'])}"
            lines.append(f"      {name:16} {size}   95 %: {interval}")
    for part, gaps in (("training", answer["gap"]["train"]), ("held out", answer["gap"]["holdout"])):
        digits, floor = (2, "   (floor 1)") if gaps["before"] > 1 else (3, "   (noise)")
        lines.append(f"  gap {part:9} {gaps['before']:7.{digits}f} -> {gaps['after']:.{digits}f}{floor}")
    for rival in answer["rivals"][:4]:
        lines.append(f"  not {' + '.join(map(_named, (rival, *rival.get('with', ()))))}: {rival['why_not']}")
    for row in answer["budget"]:
        low, high = row["share_interval"]
        lines.append(f"  share of {_named(row)}: {row['share']:z.0%}   95 %: {low:z.0%} .. {high:z.0%}")
    if answer["remainder"]:
        lines.append(
            f"  left above the floor: {answer['remainder']['share']:z.0%}, {answer['remainder']['looks_like']}"
        )
        if not answer["with_outliers"]:
            lines.append("  gap discover looks for a law that the library lacks")
    lines += [f"  {row['channel']} {row['evidence']}" for row in answer["data"] if row["kind"] == "gain"]
    if answer["next_experiment"]:
        own = "; gap design makes one for this question" * ("hinges" in answer["provenance"])
        lines.append(f"  next experiment: {answer['next_experiment']}{own}")
    for what in answer["skipped"][:4]:
        lines.append(f"  not looked at for want of time: {what}")
    return "\n".join(lines)


def _named(effect: dict[str, Any]) -> str:
    return " ".join([effect["id"], *(f"{k} {v}" for k, v in effect["location"].items())])


def _write_predictions(found: Any, folder: Path, paths: list[Path]) -> None:
    from boom_mj.diagnosis import nominal_predictor, simulated_recording, steps
    from boom_mj.logs import write_mcap
    from boom_mj.logs.columns import write_columns
    from boom_mj.replay import residual
    from boom_mj.systems.mjcf import tables

    folder.mkdir(parents=True, exist_ok=True)
    data, stems, predictor = found.model.data, _stems(paths), nominal_predictor(found)
    for effects, kind in zip(steps(found).values(), ("nominal", "as_built", "corrected")):
        said = [simulated_recording(predictor, effects, index) for index in range(len(data.recordings))]
        if found.model.facts.kind == "mjcf":
            for log_path, table in tables(data, said).items():
                write_columns(folder / f"{stems[Path(log_path)]}.{kind}.csv", table)
            continue
        for log, path, recording in zip(data.recordings, paths, said):
            beside = {"/measured": log, "/residual": residual(log, recording)}
            write_mcap(recording, folder / f"{stems[path]}.{kind}.mcap", beside=beside)


def _stems(paths: list[Path]) -> dict[Path, str]:
    """File names without endings, numbered where they are alike."""
    stems: dict[Path, str] = {}
    for path in dict.fromkeys(paths):
        stem = Path(path.name.removesuffix(".gz")).stem
        alike = sum(taken.rpartition("-")[0] == stem or taken == stem for taken in stems.values())
        stems[path] = f"{stem}-{alike + 1}" if alike else stem
    return stems
