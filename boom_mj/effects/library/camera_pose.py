"""Cameras that were moved after their calibration."""

from collections.abc import Mapping
from dataclasses import replace

from scipy.spatial.transform import Rotation

from boom_mj.effects import OutputEffect, Parameter
from boom_mj.machine import Machine
from boom_mj.recording import Signal


class CameraPose(OutputEffect):
    """All markers move together: turned about the origin by a rotation vector, then shifted."""

    id = "camera_pose"
    needs = frozenset({"boom"})
    table = {
        **{f"rotation_{axis}": Parameter("rad", 0.0, -0.5, 0.5, 0.003) for axis in "xyz"},
        **{f"translation_{axis}": Parameter("m", 0.0, -5.0, 5.0, 0.03) for axis in "xyz"},
    }
    confused_with = ("joint_zero_offset", "base_compliance", "joint_sensor_nonlinearity", "marker_slip", "link_length")
    separating_experiment = "slew_tour"

    def observe(self, signals: Mapping[str, Signal], machine: Machine) -> Mapping[str, Signal]:
        if not any(self.values.values()):
            return {}
        turn = Rotation.from_rotvec([self.values[f"rotation_{axis}"] for axis in "xyz"])
        shift = [self.values[f"translation_{axis}"] for axis in "xyz"]
        markers = signals["markers"]
        values = markers.values.reshape(-1, 3) @ turn.as_matrix().T + shift
        return {"markers": replace(markers, values=values.reshape(markers.values.shape))}
