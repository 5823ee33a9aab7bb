"""Parameters with their intervals, and what the recordings could not tell."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from boom_mj.calibration import Validation
from boom_mj.estimation.intervals import Z95
from boom_mj.report.colours import CORRECTED, FAINT, QUIET
from boom_mj.report.drawing import draw
from boom_mj.report.section import Section
from boom_mj.report.words import digits_of, gap_size, number, percent, spaced

WIDTH, ROW, MARGIN = 1080, 19, 52  # px

Figures = list[tuple[str, str, str]]


def figures(answer: Mapping[str, Any], shown: Validation) -> Figures:
    """Figure, what it is, what it means."""
    gap, known = answer["gap"], answer["identifiability"]
    found = [
        ("Told", f"{known['rank']} of {known['of']}", "directions of parameters and zero offsets that the data tell"),
        (
            "Gap",
            f"{gap_size(gap['before'])} → {gap_size(gap['after'])}",
            "rms of measured less simulated; 1 is the floor",
        ),
    ]
    for what, name in (("fall", "Stationary differences"), ("frequency", "First frequencies")):
        worst = [
            np.max(
                [abs(v[k] / v[0] - 1) for row in shown.comparisons if np.isfinite((v := getattr(row, what))[0])],
                initial=0,
            )
            for k in (1, 2)
        ]
        found.append((name, f"{percent(worst[0])} → {percent(worst[1])}", "largest error, uncalibrated and calibrated"))
    return found


def section(shown: Validation) -> Section:
    found = shown.found
    free, known = found.refined.free, found.identified
    rows = []
    for group, x, deviation in zip(found.whole.tied, found.scaled, found.deviation):
        (parameter,) = group.parameters
        low, high = (float(np.exp(x + side * Z95 * deviation)) for side in (-1, 1))
        value = parameter.value(found.machine)
        digits = digits_of(low, high)
        interval = "held" if np.isnan(deviation) else f"{number(value * low, digits)} to {number(value * high, digits)}"
        words = spaced(parameter.name.replace("_", " ").replace(".", ", "))
        rows.append((words, number(value), number(value * float(np.exp(x)), digits), interval, parameter.unit))
    offsets = [
        (f"joint {k + 1}", f"{np.degrees(v):+.3f} ± {np.degrees(Z95 * s):.3f}")
        for k, (v, s) in enumerate(zip(found.refined.scaled[-5:], found.refined.deviation[-5:]))
    ]

    def paint(figure: Figure) -> None:
        axes, count = figure.subplots(), len(free.tied)
        middle = np.exp(found.refined.scaled[:count])
        reach = np.exp(Z95 * found.refined.deviation[:count])
        place = np.arange(count)[::-1]
        axes.hlines(place, middle / reach, middle * reach, color=CORRECTED, lw=3)
        axes.plot(middle, place, "o", color=CORRECTED, ms=4.5)
        axes.axvline(1, color=QUIET, lw=0.8)
        axes.set_yticks(place, [spaced(name.replace("_", " ").replace(".", ", ")) for name in free.names[:count]])
        axes.set_xlabel("calibrated over the machine file's")
        axes.grid(axis="x", color=FAINT)

    height = MARGIN + ROW * len(free.tied)
    picture = draw("parameters", "Factors on the machine file's values with 95 % intervals", WIDTH, height, paint)
    facts = {
        "rows": rows,
        "offsets": offsets,
        "picture": picture,
        "fixed": found.fixed,
        "at_bound": found.refined.at_bound,
        "correlated": [(a, b, f"{value:+.3f}") for a, b, value in known.correlated],
        "null": [", ".join(f"{name} {weight:+.2f}" for name, weight in combination) for combination in known.null],
        "condition": number(known.condition),
    }
    return Section("parameters", "Parameters", facts)
