"""Measured, as built and with causes over each other, for the groups that matter most, with their residuals."""

from collections import defaultdict
from dataclasses import dataclass

import numpy as np
from markupsafe import Markup
from matplotlib.figure import Figure

from boom_mj.report.colours import CORRECTED, FAINT, MEASURED, NOMINAL, QUIET
from boom_mj.report.diagnosis.view import View
from boom_mj.report.drawing import draw, envelope
from boom_mj.report.section import Section
from boom_mj.report.words import capital, percent

Array = np.ndarray
SHOWN = 4  # groups
WINDOW = 25.0  # s, of the overlay; the residual is shown over the whole recording
WORTH = 0.01  # share from which a sensor's best group is shown before the second of another sensor
WIDTH, HEIGHT = 1080, 300  # px
SCALES = {"N": (1e-3, "kN"), "N m": (1e-3, "kN m"), "m": (1e3, "mm")}  # of values beyond BOUNDS
BOUNDS = {"N": (2e3, np.inf), "N m": (2e3, np.inf), "m": (0.0, 0.1)}


@dataclass(frozen=True)
class Overlay:
    """A picture, what it shows, and how much of the gap its group holds."""

    title: str
    note: str
    picture: Markup


def section(view: View) -> Section:
    share = group_shares(view)
    overlays = [overlay(view, group, share[group], k) for k, group in enumerate(chosen(view, share))]
    facts = {
        "overlays": overlays,
        "corrected": view.corrected,
        "block": f"{view.data.block_s:g}",
        "tolerances": bool(view.model.nuisances),
    }
    return Section("overlays", "How it shows", facts)


def group_shares(view: View) -> dict[str, float]:
    """Share of the squared residual of every channel group as built, largest first."""
    power: dict[str, float] = defaultdict(float)
    for number, channel in enumerate(view.data.channels):
        part = view.before[view.data.stretch(number)]
        power[channel.group] += float(part @ part)
    total = max(sum(power.values()), 1e-300)
    return {name: p / total for name, p in sorted(power.items(), key=lambda item: -item[1])}


def chosen(view: View, share: dict[str, float]) -> list[str]:
    """The best group of every sensor that holds a share worth showing, then the next best."""
    first: dict[str, str] = {}
    for group, part in share.items():
        if part >= WORTH:
            first.setdefault(view.places[group].sensor, group)
    rest = [group for group in share if group not in first.values()]
    return sorted([*first.values(), *rest][:SHOWN], key=lambda group: -share[group])


def overlay(view: View, group: str, share: float, index: int) -> Overlay:
    """The channel of a group that is worst off on what was held out."""
    data = view.data
    channels = [k for k, channel in enumerate(data.channels) if channel.group == group]
    number = max(channels, key=lambda k: _power(view, data.stretch(k)))
    channel, rows = data.channels[number], data.stretch(number)
    signal = data.recordings[channel.recording][channel.signal]
    seen = data.used[rows]
    factor, unit = _scale(signal.unit, data.measured[rows][seen])
    time = channel.time
    measured, built, corrected = (
        np.where(seen, factor * values[rows], np.nan) for values in (data.measured, view.built, view.explained)
    )
    weight = view.model.noise.weight[rows]
    spread = 2 * factor * np.where(weight > 0, 1 / np.where(weight > 0, weight, 1.0), np.nan)
    window = _window(time, np.where(seen, view.before[rows], 0.0))
    lines = [(built, NOMINAL, 1.2)] + ([(corrected, CORRECTED, 1.2)] if view.corrected else [])

    def paint(figure: Figure) -> None:
        upper, lower = figure.subplots(2, 1, height_ratios=[3, 1.3])
        inside = (time >= window[0]) & (time <= window[1])
        upper.plot(time[inside], measured[inside], color=MEASURED, lw=2.6, alpha=0.9, solid_capstyle="round")
        for values, colour, width in lines:
            upper.plot(time[inside], values[inside], color=colour, lw=width)
            lower.plot(*envelope(time, measured - values), color=colour, lw=0.8)
        lower.fill_between(time, -spread, spread, color=FAINT, lw=0, zorder=0)
        lower.axvspan(*window, color=QUIET, alpha=0.08, lw=0)
        upper.set_xlim(*window)
        lower.set_xlim(time[0], time[-1])
        upper.set_ylabel(unit)
        lower.set_ylabel(f"residual\n{unit}")
        lower.set_xlabel("time, s")
        for axes in (upper, lower):
            axes.grid(axis="y")
        figure.align_ylabels()

    several = [c for c in data.channels if (c.recording, c.group) == (channel.recording, group)]
    which = f" ({signal.channels[channel.column]})" if len(several) > 1 else ""
    name = capital(view.places[group].label) + which
    where = f"{view.recording_name(channel.recording)}, {view.part(channel.recording)}"
    picture = draw(f"overlay{index}", f"{name} in {where}: measured and simulated over time", WIDTH, HEIGHT, paint)
    return Overlay(name, f"{where}; the group holds {percent(share)} of the gap", picture)


def _scale(unit: str, values: Array) -> tuple[float, str]:
    """A factor, and the unit of what comes out, that people read well."""
    size = float(np.max(np.abs(values), initial=0.0))
    within, beyond = BOUNDS.get(unit, (np.inf, np.inf))
    return SCALES[unit] if within < size < beyond else (1.0, unit.replace("^2", "²"))


def _power(view: View, rows: slice) -> float:
    """Squared residual as built of the held-out entries; less than nothing where all are hidden."""
    held = view.data.held_out[rows]
    return float(np.sum(view.before[rows][held] ** 2)) if held.any() else -1.0


def _window(time: Array, residual: Array) -> tuple[float, float]:
    """The WINDOW seconds that hold most of a residual."""
    if time[-1] - time[0] <= 1.3 * WINDOW:
        return float(time[0]), float(time[-1])
    starts = np.arange(time[0], time[-1] - WINDOW, 1.0)
    total = np.concatenate([[0.0], np.cumsum(residual**2)])
    ends = np.searchsorted(time, starts + WINDOW)
    begin = float(starts[np.argmax(total[ends] - total[np.searchsorted(time, starts)])])
    return begin, begin + WINDOW
