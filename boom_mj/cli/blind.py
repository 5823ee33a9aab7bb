"""gap blind: make cases whose effect is sealed, diagnose them without knowing it, open the seal and score."""

import json
import os
import sys
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from boom_mj.cli.arguments import (
    AsJson,
    Cluster,
    EffectFiles,
    Jobs,
    Most,
    find_machine,
    machine_text,
    output_folder,
    output_path,
)
from boom_mj.errors import BoomError, InputError
from boom_mj.files import parse_toml, read_bytes, read_text, write_text

if TYPE_CHECKING:
    from boom_mj.blind.bench import Bench

app = typer.Typer(help="Check the diagnosis on effects that it does not know.", no_args_is_help=True)
Folder = Annotated[Path, typer.Argument(metavar="DIR", help="Folder of the sealed set.")]
Folders = Annotated[list[Path], typer.Argument(metavar="DIR...", help="Folders of sealed sets.")]
Answers = Annotated[
    list[Path] | None,
    typer.Option("--answers", "-a", metavar="DIR", help="Folder of the answers, one a set; DIR-answers if left out."),
]
Seals = Annotated[list[Path], typer.Option(metavar="FILE", help="The sealed answers, one a set.")]


@app.command()
def make(
    cases: Annotated[int, typer.Option(min=1, help="How many cases.")],
    seed_file: Annotated[
        Path, typer.Option(metavar="SECRET", help="At least 16 random bytes, to be kept from the solver.")
    ],
    output: Annotated[Path, typer.Option("-o", metavar="DIR", help="Folder for the cases.")],
    seal: Annotated[Path, typer.Option(metavar="FILE", help="File for the answers, outside DIR.")],
    machine: Annotated[
        str,
        typer.Option(
            metavar="MACHINE|MAP.toml",
            help="Machine file, or a name such as boom36; or a channel map with MAP.plant.toml beside it.",
        ),
    ] = "boom36",
    short: Annotated[
        bool, typer.Option("--short", help="Two training recordings and one held out, 150 s in all.")
    ] = False,
    mix: Annotated[str, typer.Option(metavar="CLASS=SHARE,...", help="Shares of the classes of cases.")] = "",
    clutter: Annotated[
        int, typer.Option(min=0, help="Small effects, a fifth of what is worth finding, that every machine has.")
    ] = 0,
    jobs: Jobs = 1,
    cluster: Cluster = None,
    as_json: AsJson = False,
) -> None:
    """Simulate cases with hidden effects: logs in DIR, answers in a sealed file elsewhere, its hash in DIR.

    Nothing is lost by an interruption: the same call goes on where it was.

    Example: python -m boom_mj gap blind make --cases 20 --seed-file secret.bin -o cases --seal answers.seal --jobs 2
    """
    from boom_mj.blind import MIX, make_cases
    from boom_mj.cli.progress import progress

    output_folder(output)
    output_path(seal)
    secret = read_bytes(seed_file, InputError)
    if output.resolve() in seed_file.resolve().parents:
        raise InputError(f"{seed_file}: the seed file must lie outside {output}")
    bench = _bench(machine, short)
    shares = (
        _shares(mix) if mix else {kind: share for kind, share in MIX.items() if kind != "stranger" or bench.unlisted}
    )
    with progress() as report:
        for done in make_cases(cases, secret, bench, shares, output, seal, jobs, cluster, clutter):
            report("cases", done, cases)
    published = (output / "seal.sha256").read_text().strip()
    told = {"cases": cases, "folder": str(output), "seal": str(seal), "seal_sha256": published}
    print(json.dumps(told, indent=1) if as_json else f"{cases} cases in {output}, sealed in {seal}: {published}")


@app.command()
def run(
    folder: Folder,
    jobs: Jobs = 1,
    output: Annotated[
        Path | None, typer.Option("-o", metavar="DIR", help="Folder for the answers; DIR-answers if left out.")
    ] = None,
    cluster: Cluster = None,
    most: Most = None,
    own_effects: EffectFiles = None,
    as_json: AsJson = False,
) -> None:
    """Diagnose every case that has no answer yet, each by a process that can open nothing but its case.

    Example: python -m boom_mj gap blind run cases --jobs 2
    """
    from boom_mj.blind import answer_cases, waiting_cases
    from boom_mj.cli.progress import progress

    answers = output_folder(_answers(folder, output))
    waiting, count = waiting_cases(folder, answers)
    done, failed = count - len(waiting), []
    with progress("answers") as report:
        report("answers", done, count)
        for case, error in answer_cases(waiting, answers, jobs, cluster, most):
            done += 1
            if error:
                failed.append(case.name)
                print(f"warning: case {case.name}: {error}", file=sys.stderr)
            report("answers", done, count)
    if failed:
        raise BoomError(
            f"{len(failed)} of {count} cases have no answer ({', '.join(failed)}); run again to try them again"
        )
    told = {"cases": count, "answers": str(answers)}
    print(json.dumps(told, indent=1) if as_json else f"{count} answers in {answers}")


@app.command()
def score(
    folders: Folders,
    seal: Seals,
    answers: Answers = None,
    hindsight: Annotated[
        bool, typer.Option("--hindsight", help="Also simulate the truth of every miss, about a minute each.")
    ] = False,
    jobs: Jobs = 1,
    method: Annotated[
        str, typer.Option(metavar="NAME", help="Print the row that a table of methods has for this one.")
    ] = "",
    as_json: Annotated[
        Path | None, typer.Option("--json", metavar="FILE", help="Figures and outcomes as JSON.")
    ] = None,
    page: Annotated[
        Path | None, typer.Option("-o", metavar="PAGE.md|PAGE.html", help="A page; its pictures lie beside Markdown.")
    ] = None,
    own_effects: EffectFiles = None,
) -> None:
    """Open the seal, check that it is the published one, and hold the answers against it.

    Answers of any method are CASE.json files, as README.md and answer.schema.json of the set describe.
    Several sets, each with its seal in the same order, are scored together and for themselves. In hindsight a miss
    is the search's fault where the truth leaves no more than noise, and the model's where it leaves more.

    Example: python -m boom_mj gap blind score cases --seal answers.seal -o score.html
    """
    from boom_mj.blind import (
        confusion_svg,
        html_page,
        leaderboard,
        leaderboard_row,
        markdown_page,
        pooled,
        reliability_svg,
        with_hindsight,
    )
    from boom_mj.blind import score as hold
    from boom_mj.cli.progress import progress

    if page is not None and page.suffix not in (".md", ".html"):
        raise InputError(f"{page}: a page is a .md or a .html file")
    for path in (page, as_json):
        if path is not None:
            output_path(path)
    given = answers or [_answers(folder, None) for folder in folders]
    if not len(folders) == len(seal) == len(given):
        raise InputError(f"{len(folders)} campaigns need as many seals and answers; got {len(seal)} and {len(given)}")
    alone = [hold(*one) for one in zip(folders, seal, given)]
    if hindsight:
        with progress() as report:
            told = [partial(report, f"misses of {folder.name}") for folder in folders]
            alone = [with_hindsight(*one[:3], jobs, one[3]) for one in zip(alone, folders, seal, told)]
    found = pooled(alone)
    outputs: dict[Path, str] = {}
    row = leaderboard_row(method, found.figures) if method else None
    if as_json is not None:
        outputs[as_json] = json.dumps({**found.document(), "leaderboard": row}, indent=1) + "\n"
    if page is not None and page.suffix == ".html":
        outputs[page] = html_page(found)
    elif page is not None:
        picture, diagram = page.with_suffix(".svg"), page.with_suffix(".reliability.svg")
        outputs |= {page: markdown_page(found, picture.name, diagram.name)}
        outputs |= {picture: confusion_svg(found.outcomes), diagram: reliability_svg(found.outcomes)}
    for path, text in outputs.items():
        write_text(path, text)
    for figure in found.figures:
        value = f"{figure.value:7.3g}   95 %: {figure.low:.3g} .. {figure.high:.3g}" if figure.count else "      -"
        mark = {None: " ", True: "+", False: "!"}[figure.met]
        print(f"{mark} {figure.name:74}{value}   of {figure.count}")
    for outcome in found.outcomes:
        if outcome.reason:
            left = f"; the truth leaves {outcome.truth_leaves:.2f}" if outcome.truth_leaves >= 0 else ""
            print(f"  {outcome.case}  {outcome.kind:9} {outcome.reason}{left}")
    if row:
        print(leaderboard([row]))


def _bench(machine: str, short: bool) -> "Bench":
    """Where machines of the kind that was asked for are recorded."""
    from boom_mj.blind import SHORT, SUITE, BoomBench, MjcfBench

    path = Path(machine)
    if (
        path.suffix == ".toml"
        and path.is_file()
        and "channel" in parse_toml(read_text(path, InputError), path, InputError)
    ):
        if short:
            raise InputError(f"--short is for booms; {path.with_suffix('.plant.toml')} says what a case records")
        return MjcfBench.beside(path)
    find_machine(machine)
    return BoomBench(machine_text(machine), SHORT if short else SUITE)


def _answers(folder: Path, given: Path | None) -> Path:
    return given or folder.with_name(f"{Path(os.path.realpath(folder)).name}-answers")


def _shares(mix: str) -> dict[str, float]:
    shares = {}
    for word in mix.split(","):
        kind, _, share = word.partition("=")
        try:
            shares[kind.strip()] = float(share)
        except ValueError as error:
            raise InputError(f"--mix {word}: should read class=share") from error
    return shares
