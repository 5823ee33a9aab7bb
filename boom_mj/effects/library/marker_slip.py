"""A marker that sits elsewhere than noted."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from boom_mj.effects import OutputEffect, Parameter
from boom_mj.machine import Machine
from boom_mj.recording import Signal

PER_LINK = 3


class MarkerSlip(OutputEffect):
    """One marker is off by an offset along its link, up and to the right of it.

    The link's frame is taken from the simulated markers at its ends and from the plane of the boom.
    """

    id = "marker_slip"
    at = ("marker",)
    needs = frozenset({"boom"})
    table = {f"offset_{axis}": Parameter("m", 0.0, -1.0, 1.0, 0.02) for axis in "xyz"}
    confused_with = ("thermal_bending", "camera_pose", "link_length")
    separating_experiment = "sweep"

    def observe(self, signals: Mapping[str, Signal], machine: Machine) -> Mapping[str, Signal]:
        if not any(self.values.values()):
            return {}
        markers, number = signals["markers"], int(self.location["marker"]) - 1
        points = markers.values.reshape(len(markers.time), -1, 3).copy()
        first = PER_LINK * (number // PER_LINK)
        along = points[:, first + PER_LINK - 1] - points[:, first]
        along /= np.linalg.norm(along, axis=1, keepdims=True)
        slewing = np.interp(markers.time, signals["joint/position"].time, signals["joint/position"].values[:, 0])
        right = np.stack([np.sin(slewing), -np.cos(slewing), np.zeros_like(slewing)], axis=1)
        up = np.cross(right, along)
        up /= np.linalg.norm(up, axis=1, keepdims=True)
        x, y, z = (self.values[f"offset_{axis}"] for axis in "xyz")
        points[:, number] += x * along + y * up + z * np.cross(along, up)
        return {"markers": replace(markers, values=points.reshape(markers.values.shape))}
