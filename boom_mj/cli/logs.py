"""logs: what is in a log from elsewhere."""

import dataclasses
import json
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from boom_mj.cli.arguments import AsJson, find_machine, output_path, printable
from boom_mj.cli.many_logs import ManyLogs
from boom_mj.errors import InputError
from boom_mj.files import write_text

if TYPE_CHECKING:
    from boom_mj.logs.inspection import LogSummary, Times, Topic
    from boom_mj.logs.topic_map import TopicMap
    from boom_mj.recording import Recording
    from boom_mj.replay.quality import DataFinding

SAME = 3  # decimals of an offset in rad that logs share: what noise leaves of one differs by less

app = typer.Typer(help="Logs from elsewhere: what is in them.", no_args_is_help=True)


@app.callback()
def _logs() -> None:
    """Logs from elsewhere: what is in them."""


@app.command()
def inspect(
    log: Annotated[Path, typer.Argument(metavar="LOG", help="MCAP log, ROS bag or CSV table.")],
    as_json: AsJson = False,
    as_map: Annotated[bool, typer.Option("--map", help="Only the proposed topic map, as TOML.")] = False,
) -> None:
    """Say what is in a log - topics, types, rates, jitter, gaps, clock resets, names - and propose a topic map.

    Example: python -m boom_mj logs inspect log.bag --map
    """
    from boom_mj.logs.inspection import inspect_log
    from boom_mj.logs.proposal import propose_map

    if as_json and as_map:
        raise InputError("--json holds the map as well: say either --json or --map")
    if not log.exists():
        raise InputError(f"{log}: there is no such log")
    summary = inspect_log(log)
    for remark in summary.remarks:
        print(f"warning: {printable(remark)}", file=sys.stderr)
    if as_map:
        print(propose_map(summary), end="")
    elif as_json:
        print(json.dumps(_document(summary), indent=1))
    else:
        print("\n".join((*map(printable, _lines(summary)), "", propose_map(summary))), end="")


@app.command(cls=ManyLogs)
def check(
    logs: Annotated[list[Path], typer.Argument(metavar="LOGS...", help="Training logs.")],
    holdout: Annotated[list[Path] | None, typer.Option(metavar="LOGS...", help="Held-out logs.")] = None,
    machine: Annotated[str | None, typer.Option(help="Machine file or name; the logs' own if left out.")] = None,
    topic_map: Annotated[
        Path | None, typer.Option("--map", metavar="MAP.toml", help="What feeds which signal, as for `replay`.")
    ] = None,
    fix: Annotated[
        Path | None,
        typer.Option(metavar="MAP.toml", help="Topic map to write that mends what one can; one more per odd log."),
    ] = None,
    as_json: Annotated[
        str | None, typer.Option("--json", metavar="FILE", help="Findings as JSON; - for stdout.")
    ] = None,
) -> None:
    """Say what is wrong with logs, before any physics: a sentence a finding. Exit status 0 nothing, 1 something found.

    Example: python -m boom_mj logs check a.mcap b.mcap --holdout c.mcap --fix map.toml
    """
    from boom_mj.logs import load_topic_map, read_log
    from boom_mj.replay.quality import check_recordings

    for path in (fix, None if as_json in (None, "-") else Path(str(as_json))):
        if path is not None:
            output_path(path, ".toml" if path is fix else None)
    paths = [*logs, *(holdout or ())]
    for path in paths:
        if not path.exists():
            raise InputError(f"{path}: there is no such log")
    read_with = None if topic_map is None else load_topic_map(topic_map)
    recordings = [read_log(path, read_with) for path in paths]
    name = machine or recordings[0].machine
    if not name:
        raise InputError(f"{paths[0]}: the log does not name its machine; say which with --machine")
    found = check_recordings(find_machine(name), recordings, len(logs), [str(path) for path in paths])
    text = json.dumps({"data": [finding.document() for finding in found.findings]}, indent=1)
    if as_json not in (None, "-"):
        write_text(Path(str(as_json)), text)
    if fix is not None:
        for path, content, names in _maps(fix, recordings, found.findings, paths, read_with):
            write_text(path, content)
            print(f"wrote {path}, for {', '.join(names)}", file=sys.stderr)
    if as_json == "-":
        print(text)
    else:
        print("\n".join(printable(f.sentence) for f in found.findings) or f"{len(paths)} logs: nothing found")
        for line in dict.fromkeys(f.repair.line for f in found.findings if f.repair):
            print(f"a topic map mends it: {printable(line)}")
    if found.findings:
        raise typer.Exit(1)


def _maps(
    fix: Path,
    recordings: Sequence["Recording"],
    findings: Sequence["DataFinding"],
    paths: Sequence[Path],
    read_with: "TopicMap | None",
) -> list[tuple[Path, str, list[str]]]:
    """Topic maps to write, and the logs that each is for: one for all that need the same repairs."""
    from boom_mj.logs.mending import mended_map

    repairs = {str(path): [f.repair for f in findings if f.log == str(path) and f.repair] for path in paths}
    alike: dict[tuple[Any, ...], list[int]] = {}
    for number, path in enumerate(paths):
        if own := repairs[str(path)]:
            key = tuple((r.signal, r.channel, r.unit, r.sign, r.source, round(r.offset, SAME)) for r in own)
            alike.setdefault(key, []).append(number)
    found = []
    for count, numbers in enumerate(sorted(alike.values(), key=len, reverse=True)):
        names = [str(paths[k]) for k in numbers]
        place = fix if count == 0 else fix.with_name(f"{fix.stem}-{count + 1}{fix.suffix}")
        content = mended_map(recordings[numbers[0]], repairs[names[0]], read_with)
        found.append((place, f"# For {', '.join(names)}\n\n{content}", names))
    return found


def _document(summary: "LogSummary") -> dict[str, Any]:
    from boom_mj.logs.proposal import propose_map

    topics = []
    for topic in summary.topics:
        topics.append(
            {
                "topic": topic.channel.topic,
                "channel": topic.channel.id,
                "type": topic.channel.type,
                "encoding": topic.channel.encoding,
                "messages": topic.count,
                "time_base": topic.time_base,
                "log_time": _plain(topic.log),
                "header_time": _plain(topic.header),
                "time_fields": {name: _plain(times) for name, times in topic.own.items()},
                "frames": topic.frames,
                "fields": {
                    path: {name: _range(r.least, r.most, r.missing) for name, r in ranges.items()}
                    for path, ranges in topic.fields.items()
                },
                "findings": _findings(topic),
            }
        )
    return {
        "log": str(summary.path),
        "format": summary.format,
        "labels": dict(summary.labels),
        "warnings": summary.remarks,
        "topics": topics,
        "map": propose_map(summary),
    }


def _plain(times: "Times | None") -> dict[str, Any] | None:
    return None if times is None else dataclasses.asdict(times)


def _range(least: float, most: float, missing: int) -> dict[str, Any]:
    known = least <= most
    return {"min": least if known else None, "max": most if known else None, "nan": missing}


def _lines(summary: "LogSummary") -> list[str]:
    lines = [f"{summary.path}: {summary.format}" + "".join(f", {k} {v}" for k, v in summary.labels.items() if v)]
    width = max((len(topic.channel.topic) for topic in summary.topics), default=0)
    for topic in summary.topics:
        times = topic.header if topic.time_base == "header" else topic.log
        when = (
            ""
            if times is None
            else (
                f"{times.rate_hz:8.2f} Hz, jitter {times.jitter_ms:.2f} ms, {times.start:.3f} to {times.stop:.3f} s "
                f"({topic.time_base} time)"
            )
        )
        kind = f"{topic.channel.type} in {topic.channel.encoding}"
        lines.append(f"{topic.channel.topic:{width}}  {topic.count:7d} x {kind}, channel {topic.channel.id} {when}")
        for path, ranges in topic.fields.items():
            shown = [f"{name} {r.least:.4g}..{r.most:.4g}" for name, r in list(ranges.items())[:8] if r.least <= r.most]
            lines.append(f"    {path}: {', '.join(shown)}" + (", ..." if len(ranges) > 8 else ""))
        lines += [f"    time column {name}: {_span(run)}" for name, run in topic.own.items()]
        lines += [f"    ! {finding}" for finding in _findings(topic)]
    return lines


def _span(times: "Times") -> str:
    """From when to when a column of times goes, in its own unit."""
    step = 1 / times.rate_hz if times.rate_hz else 0.0
    return f"{times.start:.10g} to {times.stop:.10g}, usual step {step:.6g}"


def _findings(topic: "Topic") -> list[str]:
    """What is wrong with a topic, in sentences."""
    from boom_mj.logs.checks import SLOW, slow_rate

    found = [topic.problem] if topic.problem else []
    bases = [("header", topic.header), ("log", topic.log), *topic.own.items()]
    for base, times in bases:
        if times is None:
            continue
        if times.resets:
            found.append(f"{base} time: set back {times.resets} times, first after {times.first_reset:.3f} s")
        if times.repeated:
            found.append(f"{base} time: {times.repeated} messages repeat the time before")
        if times.late:
            found.append(f"{base} time: {times.late} messages come late, out of order")
        if times.gaps:
            longest = f"the longest {times.longest_gap:.3f} s after {times.longest_gap_at:.3f} s"
            found.append(f"{base} time: {times.gaps} gaps, {longest}")
    if topic.header is not None and not topic.header.stop:
        found.append("header stamps are all 0")
    times = topic.header if topic.time_base == "header" else topic.log
    angles = {name for ranges in topic.fields.values() for name in ranges if "joint" in name.lower()}
    if times is not None and angles and 0 < times.rate_hz < SLOW:
        found.append(slow_rate(times.rate_hz))
    for path, ranges in topic.fields.items():
        if missing := {name: r.missing for name, r in ranges.items() if r.missing}:
            found.append(f"{path}: {sum(missing.values())} values are NaN ({', '.join(list(missing)[:5])})")
    return found
