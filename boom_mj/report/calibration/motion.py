"""The longest motion: the tip's path, its position error, joint angles and elastic coordinates."""

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from boom_mj.calibration import Validation
from boom_mj.calibration.release import stop_of
from boom_mj.report.calibration.pictures import LINES, Picture, trace
from boom_mj.report.drawing import draw, envelope
from boom_mj.report.section import Section

Array = np.ndarray
WIDTH = 1080
ABOVE: Any = {"frameon": False, "loc": "lower left", "bbox_to_anchor": (0.0, 1.0), "borderaxespad": 0.0}  # a legend
SHADES = ("#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#5b6270")  # joints, links, axes: none is a machine's colour


def section(shown: Validation) -> Section | None:
    moving = [k for k, table in enumerate(shown.logs) if stop_of(table) is not None]
    if not moving:
        return None
    index = max(moving, key=lambda k: shown.logs[k].time[-1])
    table, twins = shown.logs[index], shown.twins[index]
    tips = [trace(shown, index, "markers", 33 + axis) for axis in range(3)]
    pictures = []
    if all(tip is not None for tip in tips):
        there = [tip for tip in tips if tip is not None]
        miss = [np.sqrt(sum((tip.values[0] - tip.values[k]) ** 2 for tip in there)) for k in (1, 2)]

        def paint_tip(figure: Figure) -> None:
            upper, lower = figure.subplots(2, 1, height_ratios=[2, 1.4], sharex=True)
            for tip, name, colour in zip(there, "xyz", SHADES):
                upper.plot(*envelope(tip.time, tip.values[0]), color=colour, lw=2.4, alpha=0.35)
                upper.plot(*envelope(tip.time, tip.values[2]), color=colour, lw=1.0, label=name)
            upper.set_ylabel("marker 12, m\nwide: measured")
            upper.legend(**ABOVE, ncols=3)
            for values, (colour, width) in zip(miss, LINES):
                lower.plot(*envelope(there[0].time, 100 * values), color=colour, lw=width)
            lower.set_ylabel("position error, cm")
            lower.set_xlabel("time, s")
            for axes in (upper, lower):
                axes.grid(axis="y")
            figure.align_ylabels()

        rms = [100 * float(np.sqrt(np.nanmean(values**2))) for values in miss]
        note = f"position error, rms: {rms[0]:.2f} cm uncalibrated, {rms[1]:.2f} cm calibrated, sensor noise included"
        pictures.append(
            Picture("Tip", note, draw("motion-tip", "Path and position error of the tip", WIDTH, 380, paint_tip))
        )
    motion = twins[1].motion
    step = max(1, round(0.1 / (motion.time[1] - motion.time[0])))
    time, joints, ritz = motion.time[::step], motion.joints[::step], motion.ritz[::step].reshape(-1, 4, 3)

    def paint_coordinates(figure: Figure) -> None:
        panels = figure.subplots(2, 2, sharex=True)
        for k in range(5):
            panels[0, 0].plot(time, np.degrees(joints[:, k]), color=SHADES[k], lw=1.1, label=f"q{k + 1}")
        for axes, column, label, factor in zip(
            panels.ravel()[1:], (1, 2, 0), ("bending v, cm", "bending w, cm", "torsion, deg"), (100, 100, 180 / np.pi)
        ):
            for link in range(4):
                axes.plot(
                    time, factor * ritz[:, link, column], color=SHADES[link + 1], lw=1.0, label=f"link {link + 2}"
                )
            axes.set_ylabel(label)
        panels[0, 0].set_ylabel("joint angles, deg")
        panels[0, 0].legend(**ABOVE, ncols=5)
        panels[0, 1].legend(**ABOVE, ncols=4)
        for axes in panels.ravel():
            axes.grid(axis="y")
        for axes in panels[1]:
            axes.set_xlabel("time, s")

    title = "Generalised coordinates of the calibrated machine"
    pictures.append(Picture(title, "", draw("motion-coordinates", title, WIDTH, 400, paint_coordinates)))
    seen = "not seen in the calibration" if index >= shown.training else "seen in the calibration"
    text = f"{table.log.name.replace('_', ' ')}, {table.time[-1]:.0f} s, {seen}; the logged angles drive the machines."
    return Section("motion", "The longest motion", {"pictures": pictures, "text": text})
