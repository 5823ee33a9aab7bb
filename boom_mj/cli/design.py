"""gap design: the experiment that tells most."""

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from boom_mj.cli.arguments import AnswerFile, EffectFiles, find_machine, output_path, stopwatch
from boom_mj.errors import InputError
from boom_mj.files import write_text

if TYPE_CHECKING:
    from boom_mj.systems.boom.design import Design, Explanation, Outlook

PLUS = "+"


def command(
    answer: Annotated[
        Path | None, typer.Argument(metavar="[ANSWER.json]", help="Of `gap diagnose --json`: its ties, or its sizes.")
    ] = None,
    output: Annotated[
        Path | None, typer.Option("-o", metavar="EXPERIMENT.toml", help="The experiment, for `simulate`.")
    ] = None,
    between: Annotated[
        list[str] | None,
        typer.Option(
            metavar="EFFECTS",
            help="An explanation, effects joined by +, as --effect of `simulate` has them; several tie, of one the "
            "sizes are asked for. Instead of an answer.",
        ),
    ] = None,
    machine: Annotated[str | None, typer.Option(help="Machine file or name; the answer's own if left out.")] = None,
    seconds: Annotated[float, typer.Option(min=10, max=600, help="That the experiment may last, s.")] = 60.0,
    load: Annotated[float, typer.Option(min=0, help="That a rope on the tip may pull with before it is cut, N.")] = 0.0,
    tries: Annotated[int, typer.Option(min=1, help="Random experiments, and as many variations of the best.")] = 20,
    seed: Annotated[int, typer.Option(min=0, help="Of what is drawn.")] = 0,
    as_json: AnswerFile = None,
    own_effects: EffectFiles = None,
) -> None:
    """Design the experiment that tells best which of the explanations that tie holds, or how large the causes are.

    Example: python -m boom_mj gap design gap.json -o next.toml
    """
    import numpy as np

    from boom_mj.blind.answers import read_answer
    from boom_mj.systems.boom.design import asked_of, designed
    from boom_mj.systems.boom.motions import as_toml

    table = None if as_json in (None, "-") else output_path(Path(str(as_json)))
    if output is not None:
        output_path(output, ".toml")
    if (answer is None) == (between is None):
        raise InputError("give an answer of `gap diagnose --json`, or explanations with --between")
    given = read_answer(answer) if answer is not None else {}
    explanations = _of_words(between) if between is not None else asked_of(given, str(answer))
    name = machine or given.get("provenance", {}).get("machine")
    if name is None:
        raise InputError("of which machine? Say it with --machine")
    found = designed(find_machine(name), explanations, seconds, load, tries, np.random.default_rng(seed), stopwatch())
    document = _document(found, explanations)
    text = json.dumps(document, indent=1)
    try:
        if output is not None:
            write_text(output, f"# {document['sentence']}\n{as_toml(found.best[0])}")
        if table is not None:
            write_text(table, text)
    finally:  # a full disk does not cost the answer
        print(text if as_json == "-" else _summary(document, as_toml(found.best[0])))


def _of_words(between: Sequence[str]) -> "list[Explanation]":
    from boom_mj.effects import parse_effect
    from boom_mj.systems.boom.design import Explanation

    return [Explanation.of(tuple(parse_effect(word.strip()) for word in one.split(PLUS))) for one in between]


def _document(found: "Design", explanations: "Sequence[Explanation]") -> dict[str, Any]:
    names, first = [" and ".join(map(_named, own.effects)) for own in explanations], explanations[0]
    (plan, outlook), known = found.best, found.catalogue
    apart = outlook.separation
    sentence = f"It tells {' from '.join(names)} by {apart or 0:.3g} standard deviations"
    sizes = [
        {"id": first.effects[k].id, "location": first.effects[k].location, "parameter": name, "left": left}
        for (k, name, _), left in zip(first.parameters, outlook.left)
    ]
    return {
        "sentence": sentence if apart is not None else f"It tells the sizes of {names[0]}",
        "explanations": names,
        "designed": _outlook(outlook),
        "sizes": sizes,
        "catalogue": {"name": known[0].name, **_outlook(known[1])} if known else None,
        "random": _outlook(found.random[1]) if found.random else None,
        "experiment": plan.model_dump(mode="json"),
    }


def _outlook(outlook: "Outlook") -> dict[str, Any]:
    return {"separation": outlook.separation, "probability": outlook.probability, "gain": outlook.gain}


def _named(effect: Any) -> str:
    return " ".join([effect.id, *(f"{k} {v}" for k, v in effect.location.items())])


def _summary(document: Mapping[str, Any], experiment: str) -> str:
    lines = [f"designed: {document['sentence']}.", ""]
    rows = [("designed", document["designed"]), ("random, median", document["random"])]
    if document["catalogue"]:
        rows.insert(1, (f"catalogue: {document['catalogue']['name']}", document["catalogue"]))
    for name, row in rows:
        if row and row["separation"] is not None:
            lines.append(f"  {name:40} {row['separation']:8.3g} apart, the right one gets {row['probability']:.2f}")
        elif row:
            lines.append(f"  {name:40} {row['gain']:8.3g} of information, log det")
    for size in document["sizes"]:
        lines.append(f"  {size['id']} {size['parameter']}: its interval shrinks to {size['left']:.2g} of what it is")
    return "\n".join([*lines, "", experiment])
