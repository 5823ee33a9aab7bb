"""Stationary differences of marker 12 and first frequencies: measured, uncalibrated, calibrated."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from boom_mj.calibration import Comparison, Validation
from boom_mj.report.colours import CORRECTED, MEASURED, NOMINAL
from boom_mj.report.drawing import draw
from boom_mj.report.section import Section
from boom_mj.report.words import MINUS

Array = np.ndarray
WIDTH, HEIGHT, GAP = 1080, 250, 0.27
COLOURS = (MEASURED, NOMINAL, CORRECTED)


def section(shown: Validation) -> Section | None:
    rows = shown.comparisons
    if not rows:
        return None
    loads = [row for row in rows if np.isfinite(row.fall[0])]

    def paint(figure: Figure) -> None:
        left, right = figure.subplots(1, 2, width_ratios=[max(len(loads), 1), len(rows)])
        _bars(left, loads, [100 * row.fall for row in loads], "fall of marker 12, cm")
        _bars(right, rows, [row.frequency for row in rows], "first frequency, Hz")

    facts = {
        "falls": [(row.name, row.direction, *_cells(1000 * row.fall, 0)) for row in loads],
        "frequencies": [(row.name, row.direction, *_cells(row.frequency, 4)) for row in rows],
        "numbers": [(k + 1, row.name) for k, row in enumerate(rows)],
        "seen": [row.index < shown.training for row in rows],
        "picture": draw("stationary", "Stationary differences and first frequencies", WIDTH, HEIGHT, paint),
    }
    return Section("stationary", "Stationary differences and first frequencies", facts)


def _bars(axes: Axes, rows: Sequence[Comparison], values: Sequence[Array], label: str) -> None:
    for k, colour in enumerate(COLOURS):
        place = np.arange(len(rows)) + (k - 1) * GAP
        axes.bar(place, [v[k] for v in values], 0.9 * GAP, color=colour)
    axes.set_xticks(np.arange(len(rows)), [str(k + 1) for k in range(len(rows))])
    axes.set_ylabel(label)
    axes.set_xlabel("experiment")
    axes.grid(axis="y")


def _cells(values: Array, digits: int) -> tuple[str, str, str, str, str]:
    """Measured; uncalibrated and its error; calibrated and its error."""
    measured, *others = values
    cells = [f"{measured:.{digits}f}"]
    for value in others:
        cells += [f"{value:.{digits}f}", f"{100 * (value / measured - 1):+.2f}".replace("-", MINUS)]
    return tuple(cells)  # type: ignore[return-value]
