"""schema: what the JSON documents of all commands hold."""

import json
from typing import Annotated, Any

import typer

from boom_mj.errors import InputError


def command(
    name: Annotated[
        str | None, typer.Argument(metavar="COMMAND", help="One, such as 'gap diagnose'; all if left out.")
    ] = None,
) -> None:
    """Print the JSON Schema of what --json writes: keys that stay, the required ones in every document.

    Documents may hold more keys than these, and later versions add some.

    Example: python -m boom_mj schema "gap diagnose"
    """
    print(json.dumps(schema(name), indent=1))


def schema(name: str | None = None) -> dict[str, Any]:
    """JSON Schema (2020-12) of the documents: those of commands under $defs, or that of one command."""
    from pydantic.json_schema import models_json_schema

    from boom_mj.cli.documents import DOCUMENTS

    if name is not None and name not in DOCUMENTS:
        raise InputError(f"there is no document of {name!r}; there are those of {', '.join(DOCUMENTS)}")
    wanted = DOCUMENTS if name is None else {name: DOCUMENTS[name]}
    models = [(model, "validation") for kinds in wanted.values() for model in kinds]
    places, whole = models_json_schema(models, ref_template="#/$defs/{model}")  # type: ignore[arg-type]
    refs = {command: [places[model, "validation"] for model in kinds] for command, kinds in wanted.items()}
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": f"boom_mj {name or 'documents'}",
        "anyOf": [ref for kinds in refs.values() for ref in kinds],
        "commands": refs,
        "$defs": whole["$defs"],
    }
