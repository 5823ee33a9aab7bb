"""The tables of the page of files: keys, signals and units, as the code has them."""

import inspect
import json
import re
from importlib import import_module
from pathlib import Path

from pydantic import BaseModel

from boom_mj.logs.topics import TOPICS
from boom_mj.logs.units import UNITS
from boom_mj.recording import QUANTITIES

ROOT = Path(__file__).parents[1]


def with_keys(markdown: str) -> str:
    """The page of files with the tables that its comments ask for."""
    fills = {"keys": _keys, "file": _shown, "signals": _signals, "units": _units}
    return re.sub(r"^<!-- (\w+)(?:: (\S+))? -->$", lambda m: fills[m[1]](m[2] or ""), markdown, flags=re.M)


def _keys(path: str) -> str:
    """Keys of a table of a file, with what its class says of them."""
    module, _, name = path.rpartition(".")
    kind = getattr(import_module(module), name)
    said = _attributes(inspect.getdoc(kind) or "")
    lines = ["| key | if left out | |", "|---|---|---|"]
    for field, info in kind.model_fields.items():
        default = info.get_default(call_default_factory=True)
        empty = default in ((), {}, "", None) or isinstance(default, BaseModel)
        left_out = "required" if info.is_required() else "" if empty else f"`{json.dumps(default)}`"
        lines.append(f"| `{info.alias or field}` | {left_out} | {said.get(field, '')} |")
    return "\n".join(lines)


def _attributes(text: str) -> dict[str, str]:
    """By name, what the section "Attributes:" of a docstring says."""
    _, _, section = text.partition("Attributes:\n")
    entries = re.findall(r"^    (\w[\w, ]*): (.*(?:\n     .*)*)", section, re.M)
    return {name: re.sub(r"\s+", " ", said).rstrip(".") for names, said in entries for name in names.split(", ")}


def _shown(path: str) -> str:
    return f"```toml\n{(ROOT / path).read_text()}```"


def _signals(_: str) -> str:
    """Every signal that a log may hold: where, in what unit and frame, with which channels."""
    lines = ["| signal | topic | message | unit | frame | channels |", "|---|---|---|---|---|---|"]
    for topic in TOPICS:
        for signal in topic.signals.values():
            quantity = QUANTITIES[signal]
            names = quantity.channels or ("any number of points",)
            shown = ", ".join(names if len(names) < 6 else (names[0], "..", names[-1]))
            what = f"{topic.kind.ros_type} | {quantity.unit} | {quantity.frame} | {shown}"
            lines.append(f"| `{signal}` | `{topic.name}` | {what} |")
    return "\n".join(lines)


def _units(_: str) -> str:
    return "\n".join(f"| {si} | {', '.join(known)} |" for si, known in UNITS.items())
