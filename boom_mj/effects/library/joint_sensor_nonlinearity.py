"""A joint angle sensor that is not linear over its range."""

from collections.abc import Sequence

import numpy as np

from boom_mj.effects.effect import AngleEffect, Array, Location, Parameter, Values

PERIODS = (1.0, 2.0, 3.0, 4.0)


class JointSensorNonlinearity(AngleEffect):
    """The sensor reads too much by a sin(n q + phi), repeatable over the angle q."""

    id = "joint_sensor_nonlinearity"
    places = {"joint": (1, 2, 3, 4, 5)}
    parameters = {
        "amplitude": Parameter("rad", 0.0, 0.0, 0.1, 0.005),
        "periods": Parameter("1/turn", 1.0, 0.2, 12.0, 0.2),
        "phase": Parameter("rad", 0.0, -20.0, 20.0, 0.3),
    }
    confused_with = ("camera_pose", "joint zero offsets", "joint_play")
    told_by = "slew_tour"

    def error(self, angles: Array) -> Array:
        error, column = np.zeros_like(angles), int(self.location["joint"]) - 1
        phase = self.values["periods"] * angles[:, column] + self.values["phase"]
        error[:, column] = self.values["amplitude"] * np.sin(phase)
        return error

    @classmethod
    def probes(cls, location: Location, lines: Sequence[float] = ()) -> list[list[dict[str, float]]]:
        """Sine and cosine at a few periods."""
        return [[{"amplitude": 0.005, "periods": n, "phase": p} for p in (0.0, np.pi / 2)] for n in PERIODS]

    @classmethod
    def blend(cls, probes: Sequence[Values], weights: Array) -> dict[str, float]:
        """Amplitude and phase of a period."""
        sine, cosine = 0.005 * np.asarray(weights)
        return {
            "amplitude": float(min(np.hypot(sine, cosine), 0.1)),
            "periods": probes[0]["periods"],
            "phase": float(np.arctan2(cosine, sine)),
        }
