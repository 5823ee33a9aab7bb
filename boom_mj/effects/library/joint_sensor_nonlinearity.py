"""A joint angle sensor that is not linear over its range."""

from collections.abc import Sequence

import numpy as np

from boom_mj.effects import AngleEffect, Array, Parameter, Site, Values

PERIODS = (1.0, 2.0, 3.0, 4.0)


class JointSensorNonlinearity(AngleEffect):
    """The sensor reads too much by a sin(n q + phi), repeatable over the angle q."""

    id = "joint_sensor_nonlinearity"
    table = {
        "amplitude": Parameter("rad", 0.0, 0.0, 0.1, 0.005),
        "periods": Parameter("1/turn", 1.0, 0.2, 12.0, 0.2),
        "phase": Parameter("rad", 0.0, -20.0, 20.0, 0.3),
    }
    confused_with = ("camera_pose", "joint_zero_offset", "joint_play")
    separating_experiment = "slew_tour"

    def error(self, angle: Array) -> Array:
        return self.values["amplitude"] * np.sin(self.values["periods"] * angle + self.values["phase"])

    @classmethod
    def screening(cls, site: Site, lines_hz: Sequence[float] = ()) -> list[list[dict[str, float]]]:
        """Sine and cosine at a few periods."""
        return [[{"amplitude": 0.005, "periods": n, "phase": p} for p in (0.0, np.pi / 2)] for n in PERIODS]

    @classmethod
    def combine(cls, site: Site, points: Sequence[Values], weights: Array) -> dict[str, float]:
        """Amplitude and phase of a period."""
        sine, cosine = 0.005 * np.asarray(weights)
        return {
            "amplitude": float(min(np.hypot(sine, cosine), 0.1)),
            "periods": points[0]["periods"],
            "phase": float(np.arctan2(cosine, sine)),
        }
