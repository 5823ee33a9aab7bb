"""An IMU mounted askew."""

from collections.abc import Mapping
from dataclasses import replace

from scipy.spatial.transform import Rotation

from boom_mj.effects import OutputEffect, Parameter
from boom_mj.machine import Machine
from boom_mj.recording import Signal


class ImuMisalignment(OutputEffect):
    """The IMU's frame is the link's, turned by a rotation vector r: it reads R(r)^T times what is true there."""

    id = "imu_misalignment"
    at = ("link",)
    needs = frozenset({"boom"})
    table = {f"rotation_{axis}": Parameter("rad", 0.0, -0.5, 0.5, 0.01) for axis in "xyz"}
    confused_with = ("base_tilt", "imu_bias", "thermal_bending")
    separating_experiment = "slew_tour"

    def observe(self, signals: Mapping[str, Signal], machine: Machine) -> Mapping[str, Signal]:
        if not any(self.values.values()):
            return {}
        turn = Rotation.from_rotvec([self.values[f"rotation_{axis}"] for axis in "xyz"]).inv()
        names = [f"imu/link{self.location['link']}/{kind}" for kind in ("specific_force", "angular_rate")]
        return {name: replace(signals[name], values=signals[name].values @ turn.as_matrix().T) for name in names}
