"""Gaps before and after, by channel group, recording, phase, link and sensor."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from markupsafe import Markup
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from boom_mj.diagnosis import Diagnosis
from boom_mj.report.colours import CORRECTED, FAINT, NOMINAL
from boom_mj.report.diagnosis.view import Change, View, view_of
from boom_mj.report.drawing import draw, gap_axis
from boom_mj.report.section import Section
from boom_mj.report.words import spaced

ROW, WIDTH, LABELS = 17, 530, 215  # px: of a row, of a picture, of its labels
TOP, BOTTOM = 4, 42  # px above the rows and below them
LONGEST = 38  # letters of a label


def section(view: View) -> Section:
    groups = [Change(view.places[name].label, c.before, c.after) for name, c in view.by_group.items()]
    recordings = view.by_recording
    values = [gap for change in (*groups, *recordings) for gap in (change.before, change.after)]
    parts = [("recording", "By recording", recordings)]
    parts += [(axis, f"By {axis}, held out", changes) for axis, changes in by_axis(view).items() if len(changes) > 1]
    facts = {
        "groups": dumbbells("group", "By channel group, held out", groups, values, view.corrected),
        "parts": [(title, dumbbells(name, title, rows, values, view.corrected)) for name, title, rows in parts],
        "corrected": view.corrected,
        "worst": max(groups, key=lambda change: change.after, default=None),
    }
    return Section("change", "Before and after", facts)


def by_axis(view: View) -> dict[str, list[Change]]:
    """Held-out gaps by phase, by link and by sensor."""
    places = [view.places[channel.group] for channel in view.data.channels]
    held_out = view.data.held_out
    found = {
        "phase": view.changes_within(view.phases, held_out),
        "link": view.changes([place.part for place in places], held_out),
        "sensor": view.changes([place.sensor for place in places], held_out),
    }
    return {
        axis: [Change(spaced(name), c.before, c.after) for name in view.order[axis] if (c := changes.get(name))]
        for axis, changes in found.items()
    }


def dumbbells(name: str, title: str, changes: Sequence[Change], values: Sequence[float], corrected: bool) -> Markup:
    """One row per part: gaps as built and with causes, joined.

    Args:
        values: that the axis must hold, so that pictures side by side have one scale.
    """
    if not changes:
        return Markup("<p>Nothing was held out.</p>")
    heard = "; ".join(f"{c.name} {c.before:.3g} to {c.after:.3g}" for c in changes)

    height = TOP + ROW * len(changes) + BOTTOM

    def paint(figure: Figure) -> None:
        figure.set_layout_engine("none")  # one place for all axes, so that columns align
        share = ROW * len(changes) / height
        axes = figure.add_axes((LABELS / WIDTH, BOTTOM / height, 1 - (LABELS + 12) / WIDTH, share))
        draw_changes(axes, changes, values, corrected)

    return draw(name, f"{title}: gap before and after: {heard}", WIDTH, height, paint)


def draw_changes(axes: Axes, changes: Sequence[Change], values: Sequence[float], corrected: bool) -> None:
    """The rows of `dumbbells` into axes."""
    rows = np.arange(len(changes))
    before, after = np.array([c.before for c in changes]), np.array([c.after for c in changes])
    gap_axis(axes, np.asarray(values))
    if corrected:
        axes.hlines(rows, np.minimum(before, after), np.maximum(before, after), color=FAINT, lw=3)
        axes.plot(after, rows, "o", ms=6, color=CORRECTED, clip_on=False)
    axes.plot(before, rows, "o", ms=6, mfc="white" if corrected else NOMINAL, mec=NOMINAL, mew=1.6)
    axes.set_yticks(rows, [_short(c.name) for c in changes])
    axes.set_ylim(len(changes) - 0.4, -0.6)
    axes.set_xlabel("gap")


def draw_gaps(axes: Axes, found: Diagnosis, answer: Mapping[str, Any]) -> None:
    """Held-out gaps of every channel group, as built and with causes, into any axes."""
    view = view_of(found, answer)
    changes = [Change(view.places[name].label, c.before, c.after) for name, c in view.by_group.items()]
    draw_changes(axes, changes, [gap for c in changes for gap in (c.before, c.after)], view.corrected)


def _short(name: str) -> str:
    return name if len(name) <= LONGEST else f"{name[: LONGEST - 1]}…"
