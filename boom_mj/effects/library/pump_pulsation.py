"""The strokes of the pump."""

from collections.abc import Mapping, Sequence

import numpy as np

from boom_mj.effects import Array, ForceEffect, Motion, Parameter, Site, Values

DIRECTIONS = {"vertical": np.array([0.0, 0.0, 1.0]), "horizontal": np.array([0.0, 1.0, 0.0])}


class PumpPulsation(ForceEffect):
    """A periodic force on the tip, F = A (sin(2 pi f t + phi) + r sin(2 (2 pi f t + phi))), t from the log's start.

    Horizontal is the world's y at q1 = 0 and turns with the boom.
    """

    id = "pump_pulsation"
    at = ("direction",)
    needs = frozenset({"boom"})
    table = {
        "amplitude": Parameter("N", 0.0, 0.0, 5e3, 100.0),
        "frequency": Parameter("Hz", 0.4, 0.02, 5.0, 0.01),
        "harmonic_ratio": Parameter("1", 0.0, 0.0, 2.0, 0.3),
        "phase": Parameter("rad", 0.0, -20.0, 20.0, 0.5),
    }
    confused_with = ("wind", "end_hose")
    separating_experiment = "hold"

    def force(self, motion: Motion) -> Mapping[str, Array]:
        phase = 2 * np.pi * self.values["frequency"] * motion.time + self.values["phase"]
        force = self.values["amplitude"] * (np.sin(phase) + self.values["harmonic_ratio"] * np.sin(2 * phase))
        x, y, z = DIRECTIONS[str(self.location["direction"])]
        slewing = motion.position["joint1"]
        cosine, sine = np.cos(slewing), np.sin(slewing)
        direction = np.stack([cosine * x - sine * y, sine * x + cosine * y, np.full_like(cosine, z)], axis=1)
        return {"tip": force[:, None] * direction}

    @classmethod
    def screening(cls, site: Site, lines_hz: Sequence[float] = ()) -> list[list[dict[str, float]]]:
        """Sine and cosine at every frequency that stands out; and at half of it, of which it may be the harmonic."""
        tones = {
            f: [{"amplitude": 100.0, "frequency": f, "phase": p} for p in (0.0, np.pi / 2)]
            for line in lines_hz
            for f in (line, line / 2)
        }
        return [group for line in lines_hz for group in (tones[line], tones[line / 2] + tones[line])]

    @classmethod
    def combine(cls, site: Site, points: Sequence[Values], weights: Array) -> dict[str, float]:
        """Amplitude and phase of the lowest tone, and the size of its harmonic."""
        sizes = [complex(*pair) for pair in np.reshape(weights, (-1, 2))]  # of sine and cosine at each frequency
        tone, harmonic = sizes[0], sum(sizes[1:])
        return {
            "amplitude": float(np.clip(100.0 * abs(tone), 0.0, 5e3)),
            "frequency": points[0]["frequency"],
            "phase": float(np.angle(tone)),
            "harmonic_ratio": float(np.clip(abs(harmonic) / max(abs(tone), 1e-9), 0.0, 2.0)),
        }
