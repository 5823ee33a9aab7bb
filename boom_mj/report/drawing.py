"""Inline SVG from matplotlib: one unit is one pixel of the page, text stays text."""

import io
import re
from collections.abc import Callable
from typing import Any

import matplotlib
import numpy as np
from markupsafe import Markup
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure

from boom_mj.report.colours import FAINT, MEASURED, NOMINAL, QUIET

Array = np.ndarray
STYLE: Any = {
    "svg.fonttype": "none",
    "svg.hashsalt": "boom_mj",
    "font.family": "sans-serif",
    "font.sans-serif": ["Arial", "Liberation Sans", "DejaVu Sans"],
    "axes.titlesize": 12.5,
    "font.size": 11,
    "axes.edgecolor": QUIET,
    "axes.labelcolor": MEASURED,
    "axes.linewidth": 0.7,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "xtick.color": QUIET,
    "ytick.color": QUIET,
    "xtick.labelcolor": MEASURED,
    "ytick.labelcolor": MEASURED,
    "xtick.labelsize": 10.5,
    "ytick.labelsize": 10.5,
    "grid.color": FAINT,
    "grid.linewidth": 0.7,
    "axes.axisbelow": True,
    "path.simplify": True,
}
DPI = 72  # units of an SVG per inch
PLAIN = {"Creator": None, "Date": None, "Format": None, "Type": None}  # metadata would name addresses
HEAT = LinearSegmentedColormap.from_list("heat", ["#ffffff", "#fde3c8", "#f5a45c", NOMINAL, "#6e2c00"])
BINS = 700  # of an envelope


def draw(name: str, description: str, width: float, height: float, paint: Callable[[Figure], None]) -> Markup:
    """What `paint` draws on a figure of so many pixels, as an SVG element.

    Args:
        name: prefix of all ids, unique on the page.
        description: for those who hear the page.
    """
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(width / DPI, height / DPI), layout="constrained")
        paint(figure)
        stream = io.StringIO()
        figure.savefig(stream, format="svg", dpi=DPI, metadata=PLAIN)
    return Markup(_inline(stream.getvalue(), name, description, width, height))


def _inline(text: str, name: str, description: str, width: float, height: float) -> str:
    body = text[text.index(">", text.index("<svg")) + 1 :]
    body = re.sub(r"<!--.*?-->\n?", "", body, flags=re.DOTALL)
    body = re.sub(r"(\d\.\d\d)\d+", r"\1", body)
    body = re.sub(r'(id="|url\(#|href="#)', rf"\1{name}-", body)
    label = str(Markup.escape(description))
    size = f'viewBox="0 0 {width:g} {height:g}" style="--natural: {width:g}px"'
    return f'<div class="drawing"><svg {size} role="img" aria-label="{label}">{body.rstrip()}</div>'


def envelope(time: Array, values: Array) -> tuple[Array, Array]:
    """A long signal as the smallest and largest value of each of BINS stretches; NaN where a stretch is hidden."""
    if len(time) <= 2 * BINS:
        return time, values
    starts = np.linspace(0, len(time), BINS + 1)[:-1].astype(int)
    ends = np.stack([np.fmin.reduceat(values, starts), np.fmax.reduceat(values, starts)], axis=1)
    return np.repeat(time[starts], 2), ends.ravel()


def gap_axis(axes: Axes, values: Array) -> None:
    """A logarithmic axis of gaps, with the floor at 1 marked."""
    low, high = min(0.8, float(np.min(values)) / 1.1), max(4.0, float(np.max(values)) * 1.15)
    axes.set_xscale("log")
    axes.set_xlim(low, high)
    axes.minorticks_off()
    axes.set_xticks(ticks := gap_ticks(low, high), [f"{t:g}" for t in ticks])
    axes.axvline(1, color=MEASURED, lw=0.9, ls=(0, (3, 2)))
    axes.grid(axis="x")
    axes.tick_params(axis="y", length=0)
    axes.spines["left"].set_visible(False)


def gap_ticks(low: float, high: float) -> list[float]:
    """1, 2, 5, 10, .. within a range; powers of ten alone where it is wide."""
    steps = (1, 2, 5) if high < 200 * low else (1,)
    return [m * 10.0**k for k in range(-2, 7) for m in steps if low <= m * 10.0**k <= high]
