"""The strokes of the pump."""

from collections.abc import Mapping, Sequence

import numpy as np

from boom_mj.effects.effect import Array, LoadEffect, Location, Parameter, Values
from boom_mj.machine import Machine

DIRECTIONS = {"vertical": np.array([0.0, 0.0, 1.0]), "horizontal": np.array([0.0, 1.0, 0.0])}


class PumpPulsation(LoadEffect):
    """A periodic force on the tip, F = A (sin(2 pi f t + phi) + r sin(2 (2 pi f t + phi))), t from the log's start.

    Horizontal is the world's y at q1 = 0 and turns with the boom.
    """

    id = "pump_pulsation"
    places = {"direction": tuple(DIRECTIONS)}
    parameters = {
        "amplitude": Parameter("N", 0.0, 0.0, 5e3, 100.0),
        "frequency": Parameter("Hz", 0.4, 0.02, 5.0, 0.01),
        "harmonic_ratio": Parameter("1", 0.0, 0.0, 2.0, 0.3),
        "phase": Parameter("rad", 0.0, -20.0, 20.0, 0.5),
    }
    confused_with = ("wind", "end_hose")
    told_by = "hold"

    def push(self, machine: Machine, time: Array, joints: Array) -> Mapping[str, Array]:
        phase = 2 * np.pi * self.values["frequency"] * time + self.values["phase"]
        force = self.values["amplitude"] * (np.sin(phase) + self.values["harmonic_ratio"] * np.sin(2 * phase))
        x, y, z = DIRECTIONS[str(self.location["direction"])]
        cosine, sine = np.cos(joints[:, 0]), np.sin(joints[:, 0])
        direction = np.stack([cosine * x - sine * y, sine * x + cosine * y, np.full_like(cosine, z)], axis=1)
        return {"tip": force[:, None] * direction}

    @classmethod
    def probes(cls, location: Location, lines: Sequence[float] = ()) -> list[list[dict[str, float]]]:
        """Sine and cosine at every frequency that stands out."""
        return [[{"amplitude": 100.0, "frequency": f, "phase": p} for p in (0.0, np.pi / 2)] for f in lines]

    @classmethod
    def blend(cls, probes: Sequence[Values], weights: Array) -> dict[str, float]:
        """Amplitude and phase of a line."""
        sine, cosine = 100.0 * np.asarray(weights)
        amplitude = float(np.clip(np.hypot(sine, cosine), 0.0, 5e3))
        return {
            "amplitude": amplitude,
            "frequency": probes[0]["frequency"],
            "phase": float(np.arctan2(cosine, sine)),
        }
