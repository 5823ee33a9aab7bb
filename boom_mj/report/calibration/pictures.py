"""Pictures of measured and simulated channels, and which recordings show most."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from markupsafe import Markup
from matplotlib.axes import Axes

from boom_mj.calibration import Comparison, Validation
from boom_mj.report.colours import CORRECTED, MEASURED, NOMINAL
from boom_mj.report.drawing import envelope

Array = np.ndarray
LINES = ((NOMINAL, 1.1), (CORRECTED, 1.1))  # of the uncalibrated and the calibrated machine


@dataclass(frozen=True)
class Picture:
    """A drawing with its title and a note."""

    title: str
    note: str
    drawing: Markup


@dataclass(frozen=True)
class Trace:
    """A channel over time: measured, uncalibrated, calibrated, (n,) each."""

    time: Array
    values: tuple[Array, Array, Array]

    def overlay(self, axes: Axes) -> None:
        """All three over each other."""
        axes.plot(self.time, self.values[0], color=MEASURED, lw=2.4, alpha=0.85, solid_capstyle="round")
        for values, (colour, width) in zip(self.values[1:], LINES):
            axes.plot(self.time, values, color=colour, lw=width)
        axes.grid(axis="y")

    def residuals(self, axes: Axes) -> None:
        """What both machines leave."""
        for values, (colour, _) in zip(self.values[1:], LINES):
            axes.plot(*envelope(self.time, self.values[0] - values), color=colour, lw=0.8)
        axes.grid(axis="y")


def trace(shown: Validation, index: int, signal: str, channel: int, factor: float = 1.0) -> Trace | None:
    """A channel of a recording and of its simulations; None where it was not recorded."""
    table = shown.logs[index]
    for column, place in enumerate(table.channels):
        if (place.signal, place.column) == (signal, channel):
            sources = (table, *(twin.table for twin in shown.twins[index]))
            measured, *simulated = (factor * source.mean[:, column] for source in sources)
            return Trace(table.time, (measured, simulated[0], simulated[1]))
    return None


def telling(shown: Validation) -> Sequence[Comparison]:
    """The largest release in every direction, and what slews."""
    best: dict[str, Comparison] = {}
    for row in shown.comparisons:
        size = abs(np.nan_to_num(row.fall[0]))
        if row.direction not in best or size > abs(np.nan_to_num(best[row.direction].fall[0])):
            best[row.direction] = row
    return [best[direction] for direction in ("vertical", "horizontal", "slewing") if direction in best]
