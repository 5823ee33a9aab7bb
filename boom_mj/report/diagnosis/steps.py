"""From the machine file to what was recorded: gaps of data sheet, machine as built, with causes; the nuisances."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from boom_mj.report.diagnosis.view import View
from boom_mj.report.section import Section
from boom_mj.report.words import MINUS, effect_name, number

STEPS = ("data_sheet", "as_built", "with_causes")


@dataclass(frozen=True)
class LogSteps:
    """A log: rms over its channel groups at every step, and its channels, worst with causes first."""

    name: str
    whole: tuple[float, ...]
    channels: Sequence[Mapping[str, Any]]


def section(view: View) -> Section:
    rows = view.answer["channels"]
    facts = {
        "logs": logs(view),
        "steps": shown(view),
        "corrected": view.corrected,
        "all": len(rows),
        "worse": sum(row["with_causes"] - row["data_sheet"] > row["uncertainty"] for row in rows),
        "nuisances": [_row(size) for size in view.answer["nuisances"]],
        "replay": _command(view),
    }
    return Section("steps", "From data sheet to recording", facts)


def shown(view: View) -> tuple[str, ...]:
    """Steps that the page has: no causes where none are named."""
    return STEPS if view.corrected else STEPS[:-1]


def logs(view: View) -> list[LogSteps]:
    """In the order of the answer."""
    found: dict[str, list[Mapping[str, Any]]] = {}
    for row in view.answer["channels"]:
        found.setdefault(row["log"], []).append(row)
    return [
        LogSteps(
            view.recording_name(view.names.index(name)) if name in view.names else name,
            tuple(float(np.sqrt(np.mean([row[step] ** 2 for row in rows]))) for step in shown(view)),
            sorted(rows, key=lambda row: -row["with_causes"]),
        )
        for name, rows in found.items()
    ]


def _row(size: Mapping[str, Any]) -> tuple[str, str, str, str]:
    """A nuisance: name, prior, estimate, unit."""
    prior, unit = size["prior"], size["unit"]
    value, neutral, deviation = (
        np.degrees(x) if unit == "rad" else x for x in (size["value"], prior["neutral"], prior["deviation"])
    )
    digits = 4 if neutral else 3
    before, after = (f"{x:.{digits}f}" if abs(x) < 100 else number(x) for x in (neutral, value))
    name = f"{effect_name(size)}, {size['parameter']}"
    return (
        name,
        f"{before} ± {number(deviation, 2)}",
        after.replace("-", MINUS),
        {"rad": "deg", "1": ""}.get(unit, unit),
    )


def _command(view: View) -> str:
    """How `replay` gives the same figures; nothing where it does not know the machine."""
    level = view.facts.fidelity.shown
    return f"--hinges {level.hinges}" if view.facts.kind == "boom" else ""
