"""Time series of releases: the tip along the load, and the forces of cylinders 2 and 3."""

from matplotlib.figure import Figure

from boom_mj.calibration import Validation
from boom_mj.report.calibration.pictures import Picture, Trace, telling, trace
from boom_mj.report.drawing import draw
from boom_mj.report.section import Section

WIDTH, HEIGHT = 1080, 300
TIP = {"vertical": (35, "tip height, cm"), "horizontal": (34, "tip sideways, cm"), "slewing": (34, "tip sideways, cm")}


def section(shown: Validation) -> Section | None:
    pictures = []
    for row in telling(shown):
        channel, label = TIP[row.direction]
        name = row.name.replace("_", " ")
        if tip := trace(shown, row.index, "markers", channel, 100.0):
            title = f"Marker 12 in {name}"
            pictures.append(_picture(f"tip-{row.direction}", title, [(tip, label)]))
        forces = [(trace(shown, row.index, "cylinder/force", k, 1e-3), f"cylinder {k + 2}, kN") for k in (0, 1)]
        there = [(found, words) for found, words in forces if found is not None]
        if there and row.direction == "vertical":
            pictures.append(_picture("forces", f"Cylinder forces in {name}", there))
    text = "Under each picture what the two machines leave of it."
    return Section("series", "Time series", {"pictures": pictures, "text": text}) if pictures else None


def _picture(name: str, title: str, traces: list[tuple[Trace, str]]) -> Picture:
    def paint(figure: Figure) -> None:
        axes = figure.subplots(2, len(traces), height_ratios=[3, 1.2], squeeze=False, sharex=True)
        for (found, label), (upper, lower) in zip(traces, axes.T):
            found.overlay(upper)
            found.residuals(lower)
            upper.set_ylabel(label)
            lower.set_ylabel("residual")
            lower.set_xlabel("time, s")
        figure.align_ylabels()

    return Picture(title, "", draw(name, f"{title}: measured and simulated over time", WIDTH, HEIGHT, paint))
