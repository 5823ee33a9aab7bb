"""The boom from the side, coloured by where the gap is sensed: links, their IMUs, markers, cylinders."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from matplotlib.patches import Polygon

from boom_mj.estimation.channels import Channel
from boom_mj.report.colours import CORRECTED, FAINT, MEASURED, QUIET
from boom_mj.report.diagnosis.geometry import Side, place_of, side_view
from boom_mj.report.diagnosis.view import View
from boom_mj.report.drawing import HEAT, draw, gap_ticks
from boom_mj.report.words import number
from boom_mj.systems.boom.system import BoomSystem
from boom_mj.systems.system import ResidualForce

Array = np.ndarray
WIDTH = 1080  # px
TRUCK = np.array([[-8.5, 0.9], [-8.5, 1.6], [0.9, 1.6], [0.9, 2.9], [2.9, 2.9], [3.1, 0.9]])  # m, a hint of one
TURRET = np.array([[-0.7, 1.6], [-0.45, 4.0], [0.45, 4.0], [0.8, 1.6]])  # m
FORCES = 5  # listed
BENDING = {"v": "bending, vertical", "w": "bending, horizontal"}
AT_TIP = ("tip_payload", "end_hose")  # effects without a location that sit at the tip


@dataclass(frozen=True)
class Sensed:
    """Gaps by part of the boom: "link5", "imu5", "marker12", "cylinder2"."""

    title: str
    gaps: Mapping[str, float]


def picture(view: View, boom: BoomSystem) -> Mapping[str, Any]:
    """What `boom.html` shows."""
    index = worst_recording(view)
    angles = view.data.recordings[index]["joint/position"].values[0]
    side = side_view(boom.machine, angles)
    states = sensed(view)
    rings = named_places(view, side)
    heights = [points[:, 1] for points in (*side.outlines, TRUCK)]
    reach = [points[:, 0] for points in (*side.outlines, TRUCK)]
    box = (min(map(np.min, reach)) - 1, max(map(np.max, reach)) + 1.5, -0.6, max(map(np.max, heights)) + 1.6)
    panel = (WIDTH - 110) / len(states)
    height = float(np.clip(panel * (box[3] - box[2]) / (box[1] - box[0]), 190, 420)) + 30
    top = max(10.0, max(states[0].gaps.values(), default=1.0))
    norm = LogNorm(1.0, top)

    def paint(figure: Figure) -> None:
        panels = np.atleast_1d(figure.subplots(1, len(states)))
        for k, (axes, state) in enumerate(zip(panels, states)):
            draw_boom(axes, side, state, norm)
            axes.set(xlim=box[:2], ylim=box[2:], aspect="equal", title=state.title)
            axes.set_axis_off()
            for place, name in rings if k == 0 else ():
                axes.plot(*place, "o", ms=26, mfc="none", mec=CORRECTED, mew=2.2)
                axes.annotate(
                    name, place, (0, -30), textcoords="offset points", ha="center", color=CORRECTED, weight="bold"
                )
        ticks = gap_ticks(1.0, top)
        bar = figure.colorbar(ScalarMappable(norm, HEAT), ax=panels, shrink=0.8, aspect=16, pad=0.01, label="gap")
        bar.set_ticks(ticks, labels=[f"{t:g}" for t in ticks])
        bar.minorticks_off()

    heard = "; ".join(f"{name} {gap:.3g}" for name, gap in states[0].gaps.items())
    forces = [force for force in view.found.forces if force.ratio > view.found.criteria.near_noise_gap]
    return {
        "picture": draw("boom", f"Side view of the boom, gap by part before: {heard}", WIDTH, height, paint),
        "recording": view.recording_name(index),
        "rings": bool(rings),
        "forces": [_shown(force) for force in forces][:FORCES],
    }


def _shown(force: ResidualForce) -> tuple[str, str, str, float]:
    """Part, direction, force and ratio as the table has them."""
    part, direction = f"{force.part[:-1]} {force.part[-1]}", BENDING.get(force.direction, force.direction)
    return part, direction, f"{number(force.force)} {force.unit}", force.ratio


def sensed(view: View) -> list[Sensed]:
    """Held-out gaps by part of the boom, before and, where something was found, after."""
    channels = view.data.channels
    parts = {**view.changes([_part(view, c) for c in channels], view.data.held_out)}
    parts |= view.changes([view.places[c.group].part for c in channels], view.data.held_out & _on_links(view))
    before = Sensed("as built", {name: change.before for name, change in parts.items()})
    after = Sensed("with causes", {name: change.after for name, change in parts.items()})
    return [before, after] if view.corrected else [before]


def _on_links(view: View) -> Array:
    """Entries of everything but the cylinders, (N,) of bool."""
    return view.data.spread([not c.signal.startswith("cylinder") for c in view.data.channels]).astype(bool)


def _part(view: View, channel: Channel) -> str:
    """The part of the boom that a channel belongs to."""
    place = view.places[channel.group]
    if place.sensor == "marker":
        return f"marker{channel.column // 3 + 1}"
    return f"{'cylinder' if place.sensor == 'cylinder' else 'imu'}{place.part[-1]}"


def worst_recording(view: View) -> int:
    """Index of the recording that holds most of the gap."""
    return int(np.argmax(np.bincount(view.data.recording_of, view.before**2)))


def named_places(view: View, side: Side) -> list[tuple[Array, str]]:
    """Places of the effects that were named, with their names."""
    found = []
    for effect in view.answer["effects"]:
        place = side.joints[-1] if effect["id"] in AT_TIP else place_of(side, effect["location"])
        if place is not None:
            found.append((place, effect["id"].replace("_", " ")))
    return found


def draw_boom(axes: Axes, side: Side, state: Sensed, norm: LogNorm) -> None:
    """Truck, cylinders, links, IMUs at the tips of the links, markers."""

    def colour(part: str) -> object:
        return HEAT(norm(max(state.gaps[part], 1.0))) if part in state.gaps else FAINT

    axes.axhline(0, color=FAINT, lw=1)
    for shape in (TRUCK, TURRET):
        axes.add_patch(Polygon(shape, fc="#eef0f2", ec=FAINT, lw=0.8))
    axes.plot([-6.5, -4.6, 1.6], [0.55] * 3, "o", ms=9, color=FAINT)
    for k, outline in enumerate(side.outlines):
        axes.add_patch(Polygon(outline, fc=colour(f"link{k + 2}"), ec=QUIET, lw=0.8, zorder=2))
    for k, ends in zip((2, 3), side.cylinders):
        axes.plot(*ends.T, color=QUIET, lw=5.5, zorder=3, solid_capstyle="round")
        axes.plot(*ends.T, color=colour(f"cylinder{k}"), lw=4, zorder=3, solid_capstyle="round")
    for k, place in enumerate(side.markers):
        axes.plot(*place, "o", ms=6.5, mfc=colour(f"marker{k + 1}"), mec=MEASURED, mew=0.8, zorder=4)
    for k, (joint, angle) in enumerate(zip(side.joints[1:], side.angles)):
        up = np.array([-np.sin(angle), np.cos(angle)])
        at = joint - 0.5 * np.array([np.cos(angle), np.sin(angle)]) + 0.75 * up
        axes.plot(*at, "s", ms=8, mfc=colour(f"imu{k + 2}"), mec=MEASURED, mew=0.8, zorder=4)
        x, z = (side.joints[k] + joint) / 2 + 1.5 * up
        axes.text(x, z, f"link {k + 2}", ha="center", va="center", fontsize=9.5, color=QUIET)
    axes.plot(*side.joints[:-1].T, "o", ms=3.5, color=MEASURED, zorder=5)
