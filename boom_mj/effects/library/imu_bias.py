"""Biases of an IMU."""

from collections.abc import Mapping
from dataclasses import replace

from boom_mj.effects import OutputEffect, Parameter
from boom_mj.machine import Machine
from boom_mj.recording import Signal

KINDS = {"accelerometer": "specific_force", "gyroscope": "angular_rate"}


class ImuBias(OutputEffect):
    """Constants on the axes of an accelerometer and of a gyroscope."""

    id = "imu_bias"
    at = ("link",)
    needs = frozenset({"boom"})
    table = {
        **{f"accelerometer_{axis}": Parameter("m/s^2", 0.0, -5.0, 5.0, 0.05) for axis in "xyz"},
        **{f"gyroscope_{axis}": Parameter("rad/s", 0.0, -0.5, 0.5, 0.003) for axis in "xyz"},
    }
    confused_with = ("imu_misalignment", "base_tilt")
    separating_experiment = "slew_tour"

    def observe(self, signals: Mapping[str, Signal], machine: Machine) -> Mapping[str, Signal]:
        changed = {}
        for sensor, kind in KINDS.items():
            name, bias = f"imu/link{self.location['link']}/{kind}", [self.values[f"{sensor}_{axis}"] for axis in "xyz"]
            if any(bias):
                changed[name] = replace(signals[name], values=signals[name].values + bias)
        return changed
