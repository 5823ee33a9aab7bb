"""A log and its simulated twin over each other, with the residual under every pair."""

from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from boom_mj.files import whole_file
from boom_mj.replay import Replay
from boom_mj.report.colours import MEASURED, NOMINAL

PANELS = (
    ("markers", "marker12/z", "tip height"),
    ("markers", "marker12/y", "tip sideways"),
    ("imu/link5/specific_force", "y", "link 5 specific force, up"),
    ("cylinder/force", "cylinder2", "cylinder 2"),
)


def draw_overlay(replay: Replay, path: Path) -> None:
    """Write a PNG with what tells most: the tip's motion, its acceleration, a cylinder's force, and all ratios."""
    panels = [panel for panel in PANELS if panel[0] in replay.log and panel[0] in replay.twin]
    figure = plt.figure(figsize=(13, 2.3 * max(len(panels), 2)), layout="constrained")
    halves = np.asarray(figure.subfigures(1, 2, width_ratios=[2.2, 1]))
    left, right = halves
    axes = left.subplots(2 * len(panels), 1, sharex=True, height_ratios=[3, 1] * len(panels), squeeze=False)[:, 0]
    for (name, channel, title), upper, lower in zip(panels, axes[::2], axes[1::2]):
        signal = replay.log[name]
        column = signal.channels.index(channel)
        measured, simulated = signal.values[:, column], replay.twin[name].values[:, column]
        upper.plot(signal.time, measured, color=MEASURED, lw=0.8, label="measured")
        upper.plot(signal.time, simulated, color=NOMINAL, lw=0.8, label="simulated")
        upper.set_ylabel(f"{title}\n{signal.unit}", fontsize=8)
        lower.plot(signal.time, measured - simulated, color=MEASURED, lw=0.5)
        lower.axhline(0, color=NOMINAL, lw=0.5)
        lower.set_ylabel("residual", fontsize=7)
    axes[0].legend(fontsize=8, loc="upper right", ncols=2)
    axes[-1].set_xlabel("time, s")
    bars = right.subplots()
    groups = replay.groups[::-1]
    bars.barh(np.arange(len(groups)), [g.ratio for g in groups], color=NOMINAL, height=0.7)
    bars.axvline(1, color=MEASURED, lw=0.8)
    bars.set_yticks(np.arange(len(groups)), [g.name for g in groups], fontsize=6)
    bars.set_xscale("log")
    bars.set_xlabel("rms(measured - simulated) / sensor noise")
    figure.suptitle(f"{replay.log.name}: log against model of {replay.twin.machine}")
    with whole_file(path) as stream:
        figure.savefig(stream, format="png", dpi=110)
    plt.close(figure)
