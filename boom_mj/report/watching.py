"""A watched machine: by how much each log is no longer what it was, and how large the causes are in each."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from boom_mj.files import whole_file
from boom_mj.report.colours import CORRECTED, MEASURED, NOMINAL, QUIET
from boom_mj.report.drawing import STYLE
from boom_mj.report.words import effect_name

WIDTH, ROW, DPI = 9.0, 1.9, 110  # inch
LEAST = 0.1  # of a limit: what is drawn of less


def draw_watch(answer: Mapping[str, Any], path: Path) -> None:
    """The document of a watch as a PNG.

    Above, the statistic of every log in terms of its limit; below, every size in every log with its 95 % interval.
    """
    logs = answer["logs"]
    sizes = [(k, name) for k, one in enumerate(logs[0]["effects"]) for name in one["parameters"]]
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(WIDTH, ROW * (1.2 + len(sizes))), layout="constrained")
        FigureCanvasAgg(figure)
        rows = figure.subplots(1 + len(sizes), 1, sharex=True, squeeze=False)[:, 0]
        _states(rows[0], logs)
        for axes, (k, name) in zip(rows[1:], sizes):
            known = [log for log in logs if log["effects"]]  # the first ones, where time was up
            _sizes(axes, [log["effects"][k] for log in known], [log["changed"] for log in known], name)
        rows[-1].set_xticks(range(len(logs)), [log["log"] for log in logs], rotation=30, ha="right")
        with whole_file(path) as stream:
            figure.savefig(stream, format="png", dpi=DPI)


def _states(axes: Axes, logs: list[dict[str, Any]]) -> None:
    shares = [max(log["statistic"] / log["limit"], LEAST) for log in logs]
    axes.bar(range(len(logs)), shares, 0.6, color=[NOMINAL if log["changed"] else QUIET for log in logs], log=True)
    axes.axhline(1, color=MEASURED, lw=0.9, ls=(0, (3, 2)))
    axes.set_ylim(LEAST, max(3.0, 1.5 * max(shares)))
    axes.set_ylabel("times the limit")
    axes.set_title("excess over healthy logs; vermilion: changed", loc="left")


def _sizes(axes: Axes, effects: list[dict[str, Any]], changed: list[bool], name: str) -> None:
    found = [one["parameters"][name] for one in effects]
    middle = np.array([one["value"] for one in found], float)
    ends = np.array([[one[end] for one in found] for end in ("low", "high")], float)
    reach = np.nan_to_num(np.abs(ends - middle), nan=0.0, posinf=0.0)
    for there, colour in ((True, CORRECTED), (False, QUIET)):
        own = np.flatnonzero((np.array(changed) == there) & np.isfinite(middle))
        axes.errorbar(own, middle[own], reach[:, own], fmt="o", ms=4, lw=1.2, capsize=3, color=colour)
    axes.set_title(effect_name(effects[0]), loc="left")
    axes.set_ylabel(name if found[0]["unit"] == "1" else f"{name}, {found[0]['unit']}")
    axes.grid(axis="y")
