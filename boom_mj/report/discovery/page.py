"""The page itself, one file that fetches nothing."""

from collections.abc import Sequence
from pathlib import Path

from boom_mj.discovery import Discovery, document
from boom_mj.files import write_text
from boom_mj.replay.quality import DataFinding
from boom_mj.report.discovery import pictures
from boom_mj.report.section import Section
from boom_mj.report.templating import page_environment
from boom_mj.report.words import gap_size, number, percent


def write_discovery(found: Discovery, names: Sequence[str], path: Path, findings: Sequence[DataFinding] = ()) -> None:
    """Write a discovery as one HTML file with everything in it.

    Args:
        names: of the logs, training first.
        findings: what is wrong with the logs themselves.
    """
    write_text(path, discovery_page(found, names, findings))


def discovery_page(found: Discovery, names: Sequence[str], findings: Sequence[DataFinding] = ()) -> str:
    """The page as text."""
    answer, sections = document(found, names, findings), []
    if found.best is not None:
        rows = pictures.missing(found, found.best)
        over = pictures.over_variables(found, found.best, rows)
        facts = {"label": rows[0].label, "variables": over, "time": pictures.over_time(found, rows)}
        sections.append(Section("law", "What is missing, and the law", facts))
    if found.front:
        facts = {"picture": pictures.front(found), "rows": answer["front"], "ties": answer["ties"]}
        sections.append(Section("front", "Longer and shorter laws", facts))
    if found.forces:
        sections.append(
            Section("forces", "A force in time", {"picture": pictures.force(found), "rows": answer["forces"]})
        )
    environment = page_environment("boom_mj.report.discovery", number=number, gap=gap_size, percent=percent)
    return environment.get_template("discovery.html").render(answer=answer, sections=sections)
