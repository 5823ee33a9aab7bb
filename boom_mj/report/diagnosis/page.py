"""The page itself: sections in their order, one template each, one file that fetches nothing."""

from collections.abc import Sequence
from pathlib import Path

from boom_mj.files import write_text
from boom_mj.gap import Diagnosis, document
from boom_mj.report.diagnosis import boom, change, ladder, left, overlays, verdict, where
from boom_mj.report.diagnosis.view import View
from boom_mj.report.templating import page_environment
from boom_mj.report.words import effect_name, gap_size, number, percent, place_name, spaced

SECTIONS = (where, boom, ladder, overlays, change, left)


def write_diagnosis(found: Diagnosis, names: Sequence[str], path: Path) -> None:
    """Write a diagnosis as one HTML file with everything in it.

    Args:
        names: of the logs, training first, as the answer lists them.
    """
    write_text(path, diagnosis_page(found, names))


def diagnosis_page(found: Diagnosis, names: Sequence[str]) -> str:
    """The page as text."""
    view = View(found, tuple(names), document(found, names))
    head, *sections = (module.section(view) for module in (verdict, *SECTIONS))
    environment = page_environment(
        "boom_mj.report.diagnosis",
        number=number,
        gap=gap_size,
        place=lambda at: place_name(*at),
        percent=percent,
        effect_name=effect_name,
        spaced=spaced,
    )
    return environment.get_template("diagnosis.html").render(view=view, head=head, sections=sections)
