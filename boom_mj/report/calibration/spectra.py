"""Spectra of the accelerations at the tip after a load is cut or a motion stops."""

import numpy as np
from matplotlib.figure import Figure

from boom_mj.calibration import Validation
from boom_mj.calibration.release import begin_of_vibration
from boom_mj.report.calibration.pictures import LINES, Picture, telling, trace
from boom_mj.report.colours import MEASURED
from boom_mj.report.drawing import draw
from boom_mj.report.section import Section
from boom_mj.systems.boom.system import BLOCK_S

WIDTH, HEIGHT = 1080, 230
AXIS = {"vertical": 1, "horizontal": 2, "slewing": 2}  # of the accelerometer
HIGHEST, LONGER = 3.0, 8  # Hz; zero padding


def section(shown: Validation) -> Section | None:
    pictures = []
    for row in telling(shown):
        found = trace(shown, row.index, "imu/link5/specific_force", AXIS[row.direction])
        begin = begin_of_vibration(shown.logs[row.index])
        if found is None or begin is None:
            continue
        rows = found.time > begin
        frequency = np.fft.rfftfreq(LONGER * int(rows.sum()), BLOCK_S)
        power = []
        for values in found.values:
            part = np.nan_to_num(values[rows] - np.nanmean(values[rows]))
            power.append(np.abs(np.fft.rfft(part * np.hanning(len(part)), LONGER * len(part))))
        shown_part = frequency <= HIGHEST

        def paint(
            figure: Figure, power: list = power, part: np.ndarray = shown_part, at: np.ndarray = frequency
        ) -> None:
            axes = figure.subplots()
            most = power[0][part].max()
            axes.plot(at[part], power[0][part] / most, color=MEASURED, lw=2.4, alpha=0.85)
            for values, (colour, width) in zip(power[1:], LINES):
                axes.plot(at[part], values[part] / most, color=colour, lw=width)
            axes.set_xlabel("frequency, Hz")
            axes.set_ylabel("amplitude over the\nlargest measured")
            axes.set_xlim(0, HIGHEST)
            axes.grid(axis="y")

        axis = "xyz"[AXIS[row.direction]]
        note = f"accelerometer of link 5, {axis}, means over {BLOCK_S} s"
        drawing = draw(
            f"spectrum-{row.direction}", f"Spectrum of the accelerations in {row.name}", WIDTH, HEIGHT, paint
        )
        pictures.append(Picture(row.name.replace("_", " "), note, drawing))
    return Section("spectra", "Spectra of the accelerations", {"pictures": pictures, "text": ""}) if pictures else None
