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
        """Sine and cosine at every frequency that stands out; and at half of it, of which it may be the harmonic."""
        tones = {
            f: [{"amplitude": 100.0, "frequency": f, "phase": p} for p in (0.0, np.pi / 2)]
            for line in lines
            for f in (line, line / 2)
        }
        return [group for line in lines for group in (tones[line], tones[line / 2] + tones[line])]

    @classmethod
    def blend(cls, probes: Sequence[Values], weights: Array) -> dict[str, float]:
        """Amplitude and phase of the lowest tone, and the size of its harmonic."""
        sizes = [complex(*pair) for pair in np.reshape(weights, (-1, 2))]  # of sine and cosine at each frequency
        tone, harmonic = sizes[0], sum(sizes[1:])
        return {
            "amplitude": float(np.clip(100.0 * abs(tone), 0.0, 5e3)),
            "frequency": probes[0]["frequency"],
            "phase": float(np.angle(tone)),
            "harmonic_ratio": float(np.clip(abs(harmonic) / max(abs(tone), 1e-9), 0.0, 2.0)),
        }
