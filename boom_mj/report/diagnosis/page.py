"""The page itself: sections in their order, one template each, one file that fetches nothing."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from boom_mj.diagnosis import Diagnosis
from boom_mj.files import write_text
from boom_mj.report.diagnosis import change, ladder, left, machine, overlays, steps, verdict, where
from boom_mj.report.diagnosis.view import view_of
from boom_mj.report.templating import page_environment
from boom_mj.report.words import effect_name, gap_size, number, percent

SECTIONS = (where, machine, ladder, steps, overlays, change, left)


def write_diagnosis(found: Diagnosis, answer: Mapping[str, Any], path: Path) -> None:
    """Write a diagnosis as one HTML file with everything in it.

    Args:
        answer: its document, with the gaps of all channels if the page shall show them.
    """
    write_text(path, diagnosis_page(found, answer))


def diagnosis_page(found: Diagnosis, answer: Mapping[str, Any]) -> str:
    """The page as text."""
    view = view_of(found, answer)
    head, *sections = (module.section(view) for module in (verdict, *SECTIONS))
    environment = page_environment(
        "boom_mj.report.diagnosis",
        number=number,
        gap=gap_size,
        place=lambda at: view.place_name(*at),
        percent=percent,
        effect_name=effect_name,
    )
    facts = {name.replace("_s", ", s"): _said(value) for name, value in view.facts.provenance.items()}
    template = environment.get_template("diagnosis.html")
    return template.render(view=view, head=head, sections=sections, provenance=facts)


def _said(value: Any) -> str:
    """A fact of how the machine was simulated, in words."""
    if isinstance(value, Mapping):
        return ", ".join(f"{name} {_said(part)}" for name, part in value.items())
    return f"{value:g}" if isinstance(value, float) else str(value)
