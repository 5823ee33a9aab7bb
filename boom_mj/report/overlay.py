"""A log and its simulated recording over each other: the worst channel first, the residual under every pair."""

from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.gridspec import GridSpec
from matplotlib.ticker import MaxNLocator
from matplotlib.transforms import ScaledTranslation

from boom_mj.files import whole_file
from boom_mj.replay import Group, Replay
from boom_mj.report.colours import MEASURED, NOMINAL, QUIET
from boom_mj.report.drawing import STYLE, envelope, gap_axis
from boom_mj.sensors import boom_lines

Array = np.ndarray
PANELS, NAMED = 4, 22  # channel groups that are drawn, and named
BAND, PALE = "#9fc5e8", "#a9b0bc"  # of noise, over what it hides; of the shape at the start
UNITS = {"N": ("kN", 1e-3), "rad/s": ("mrad/s", 1e3), "m/s^2": ("m/s²", 1.0)}  # on an axis, and factor
RESIDUAL_UNITS = {**UNITS, "m": ("mm", 1e3)}
SIZE, DPI = (13.0, 9.4), 110  # inch
LOOK: Any = {**STYLE, "font.sans-serif": ["DejaVu Sans"], "font.size": 9, "text.hinting": "none"}
"""Letters without hints take half the time."""


def draw_overlay(replay: Replay, path: Path) -> None:
    """Write `overlay` as a PNG."""
    figure = overlay(replay)
    with matplotlib.rc_context(LOOK), whole_file(path) as stream:
        figure.savefig(stream, format="png", dpi=DPI, pil_kwargs={"compress_level": 1})


def overlay(replay: Replay) -> Figure:
    """The worst channel group of every kind of sensor, the boom's shape at three moments, and all ratios."""
    panels = worst_groups(replay.groups)
    with matplotlib.rc_context(LOOK):
        figure = Figure(figsize=SIZE)
        FigureCanvasAgg(figure)
        figure.text(0.015, 0.972, _headline(replay, panels), fontsize=12.5, color=MEASURED)
        rows = GridSpec(max(len(panels), 1), 1, figure, left=0.085, right=0.585, top=0.92, bottom=0.06, hspace=0.34)
        for k, group in enumerate(panels):
            pair = rows[k].subgridspec(2, 1, height_ratios=[2.2, 1], hspace=0.12)
            axes = figure.add_subplot(pair[0]), figure.add_subplot(pair[1])
            draw_pair(*axes, replay, group, worst=k == 0)
            axes[1].tick_params(labelbottom=k == len(panels) - 1)
        if panels:
            axes[1].set_xlabel("time, s", labelpad=1)
            shown = [*figure.axes[0].get_lines(), *figure.axes[1].patches]
            place: dict[str, Any] = {"loc": "lower right", "bbox_to_anchor": (0.595, 0.944)}
            figure.legend(handles=shown, ncols=3, frameon=False, borderaxespad=0, borderpad=0, **place)
        right = GridSpec(2, 1, figure, left=0.74, right=0.985, top=0.92, bottom=0.06, height_ratios=[1, 2], hspace=0.3)
        draw_shapes(figure.add_subplot(right[0]), replay, _worst_moment(replay, panels))
        draw_ratios(figure.add_subplot(right[1]), replay.groups)
    return figure


def worst_groups(groups: tuple[Group, ...]) -> list[Group]:
    """The worst channel group of every kind of sensor, worst first, PANELS at most."""
    known = sorted((group for group in groups if np.isfinite(group.rms)), key=lambda group: -group.ratio)
    kinds: dict[str, Group] = {}
    for group in known:
        kinds.setdefault(group.signal.rpartition("/")[2], group)
    return list(kinds.values())[:PANELS]


def _headline(replay: Replay, panels: list[Group]) -> str:
    head = f"{replay.log.name}: log against model of {replay.twin.machine}"
    return f"{head}; worst is {panels[0].name}, {panels[0].ratio:.3g} times its noise" if panels else head


def _column(replay: Replay, group: Group) -> int:
    """The channel of a group that is furthest off."""
    difference = replay.log[group.signal].values - replay.twin[group.signal].values
    size = np.nansum(difference[:, group.columns] ** 2, axis=0)
    return group.columns[int(np.argmax(size))]


def _worst_moment(replay: Replay, panels: list[Group]) -> float | None:
    """Where the worst channel is furthest off, as a mean over a second, s from the first stamp."""
    if not panels:
        return None
    signal, column = replay.log[panels[0].signal], _column(replay, panels[0])
    off = np.nan_to_num(np.abs(signal.values[:, column] - replay.twin[panels[0].signal].values[:, column]))
    width = max(1, min(len(off), round(len(off) / max(signal.time[-1] - signal.time[0], 1.0))))
    smooth = np.convolve(off, np.full(width, 1 / width), "same")
    return float(signal.time[np.argmax(smooth)] - replay.log["joint/position"].time[0])


def draw_pair(upper: Axes, lower: Axes, replay: Replay, group: Group, worst: bool = False) -> None:
    """A channel group's furthest channel, log and simulation above, residual and noise below, into any two axes."""
    signal, column = replay.log[group.signal], _column(replay, group)
    measured, simulated = signal.values[:, column], replay.twin[group.signal].values[:, column]
    unit, factor = UNITS.get(group.unit, (group.unit, 1.0))
    upper.plot(*envelope(signal.time, factor * measured), color=MEASURED, lw=0.9, label="measured")
    upper.plot(*envelope(signal.time, factor * simulated), color=NOMINAL, lw=0.9, label="simulated")
    title = group.name + (f" ({signal.channels[column].partition('/')[0]})" if len(group.columns) > 1 else "")
    said = f"{title}: {group.ratio:.3g} times noise"
    _title(upper, f"worst: {said}" if worst else said, "bold" if worst else "normal")
    upper.set_ylabel(unit)
    unit, factor = RESIDUAL_UNITS.get(group.unit, (group.unit, 1.0))
    noise = factor * group.noise
    lower.plot(*envelope(signal.time, factor * (measured - simulated)), color=MEASURED, lw=0.6)
    lower.axhspan(-noise, noise, facecolor=BAND, alpha=0.55, lw=0, zorder=3, label="sensor noise, ±1 deviation")
    lower.axhline(0, color=NOMINAL, lw=0.8, zorder=4)
    lower.set_ylabel(f"residual\n{unit}")
    if worst:
        for axes in (upper, lower):
            for side in ("left", "bottom"):
                axes.spines[side].set(color=NOMINAL, linewidth=1.6)
    for axes, ticks, prune in ((upper, 4, "lower"), (lower, 3, "upper")):  # the two stand close
        axes.set_xlim(signal.time[0], signal.time[-1] if len(signal.time) > 1 else None)
        axes.yaxis.set_major_locator(MaxNLocator(ticks, prune=prune))
        axes.yaxis.set_label_coords(-0.105, 0.5)
    upper.set_xticks([])
    lower.grid(axis="x")


def draw_shapes(axes: Axes, replay: Replay, worst: float | None = None) -> None:
    """The boom from the side at three moments, in the vertical plane that turns with the slewing joint.

    Args:
        worst: the moment between start and end, s; the middle if left out.
    """
    motion = replay.trajectory
    last = float(motion.time[-1])
    moments = sorted({0.0, last / 2 if worst is None else min(max(worst, 0.0), last), last})
    steps = [int(np.searchsorted(motion.time, moment)) for moment in moments]
    slewing = motion.joints[steps, 0]
    along = np.stack([np.cos(slewing), np.sin(slewing)], axis=1)[:, :, None]  # (moments, 2, 1)
    for points, style in ((boom_lines(motion, steps, bent=False), ":"), (boom_lines(motion, steps), "-")):
        reach = (points[..., :2] @ along)[..., 0]
        for k, moment in enumerate(moments):
            shade = NOMINAL if moment == worst else QUIET if moment else PALE
            named = f"{moment:.0f} s" + (", worst" if moment == worst else "")
            axes.plot(reach[k], points[k, :, 2], style, color=shade, lw=1.6 if style == "-" else 0.9, label=named)
    axes.set_aspect("equal", adjustable="datalim")
    axes.margins(0.12)
    _title(axes, "shape")
    solid = axes.get_lines()[len(moments) :]
    place: dict[str, Any] = {"loc": "lower right", "bbox_to_anchor": (1.03, 0.985), "columnspacing": 1.0}
    axes.legend(handles=solid, ncols=3, frameon=False, handlelength=1.0, fontsize=8, **place)
    axes.set_xlabel("from the slewing axis, m   (dotted: rigid)", labelpad=1)
    axes.set_ylabel("height, m")
    axes.grid()


def draw_ratios(axes: Axes, groups: tuple[Group, ...]) -> None:
    """Gaps of all channel groups as bars, worst first."""
    known = sorted((g for g in groups if np.isfinite(g.ratio)), key=lambda group: -group.ratio)
    if not known:
        axes.set_axis_off()
        axes.text(0.5, 0.5, "the log has nothing to compare\nbut its joint angles", ha="center", color=QUIET)
        return
    shown, left = known[:NAMED], known[NAMED:]
    rows, ratios = [-float(k) for k in range(len(shown))], np.array([group.ratio for group in shown])
    axes.barh(rows[:1], ratios[:1], color=NOMINAL, height=0.7)
    axes.hlines(rows[1:], 1e-3, ratios[1:], color=NOMINAL, alpha=0.4, linewidth=9.0)
    gap_axis(axes, ratios)
    axes.set_yticks([])
    place: dict[str, Any] = {"transform": axes.get_yaxis_transform(), "ha": "right", "va": "center", "fontsize": 7.2}
    for row, group in zip(rows, shown):  # as texts, which take a fifth of the time of ticks
        axes.text(-0.015, row, group.name, fontweight="bold" if row == 0 else "normal", **place)
    if left:
        text = f"{len(left)} more, {left[0].ratio:.3g} at most"
        axes.text(-0.015, -len(shown), text, color=QUIET, **place)
    axes.set_ylim(-len(shown) - 0.6, 0.7)
    _title(axes, "rms residual / noise of the sensor")


def _title(axes: Axes, text: str, weight: str = "normal") -> None:
    """A title that does not measure everything else to find its place."""
    up = ScaledTranslation(0, 5 / 72, axes.figure.dpi_scale_trans)
    axes.text(0, 1, text, transform=axes.transAxes + up, fontsize=10, fontweight=weight)
