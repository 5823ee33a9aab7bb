"""The page itself: sections in their order, one template each, one file that fetches nothing."""

from collections.abc import Sequence
from pathlib import Path

from boom_mj.calibration import Validation, document
from boom_mj.files import write_text
from boom_mj.report.calibration import left, motion, parameters, series, spectra, stationary
from boom_mj.report.templating import page_environment
from boom_mj.report.words import percent

SECTIONS = (parameters, stationary, spectra, series, motion, left)


def write_calibration(shown: Validation, names: Sequence[str], path: Path) -> None:
    """Write a calibration and its validation as one HTML file with everything in it.

    Args:
        names: of the logs that the calibration has seen.
    """
    write_text(path, calibration_page(shown, names))


def calibration_page(shown: Validation, names: Sequence[str]) -> str:
    """The page as text."""
    answer = document(shown.found, names)
    sections = [section for module in SECTIONS if (section := module.section(shown)) is not None]
    figures = parameters.figures(answer, shown)
    environment = page_environment("boom_mj.report.calibration", percent=percent)
    return environment.get_template("calibration.html").render(answer=answer, figures=figures, sections=sections)
