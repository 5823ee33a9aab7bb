"""Wind on the links."""

from collections.abc import Mapping, Sequence
from copy import copy
from typing import ClassVar

import numpy as np
from scipy.signal import lfilter

from boom_mj.effects import Array, ForceEffect, Motion, Parameter, Site, Values
from boom_mj.estimation.latent_input import CORRELATION_S, KNOT_S

DENSITY = 1.225  # kg/m^3
DRAG = 1.3  # of a box section across the wind
SPEED = 5.0  # m/s, worth finding
MOST = 0.5  # gust strength near the ground that a diagnosis believes


class Wind(ForceEffect):
    """Drag of a horizontal wind on the sides of the links: 1/2 rho c_d h |v_n| v_n per length, v_n across the link.

    Its load is laid on the marker sites of each link. Gusts are a first-order process of relative strength
    `gust_strength`, drawn from a seed that no log tells; the diagnosis estimates them in every recording.
    """

    id = "wind"
    needs = frozenset({"boom"})
    table = {
        "mean_speed": Parameter("m/s", 0.0, 0.0, 40.0, SPEED),
        "direction": Parameter("rad", 0.0, -10.0, 10.0, 0.3),
        "gust_strength": Parameter("1", 0.0, 0.0, 1.0, 0.2),
    }
    confused_with = ("thermal_bending", "base_tilt", "joint_zero_offset", "pump_pulsation")
    separating_experiment = "slew_tour"
    gust_s: ClassVar[float | None] = None  # when a single one peaks; None for all that the seed draws

    @property
    def key(self) -> tuple[object, ...]:
        return *super().key, self.gust_s

    def basis(self, time_s: float) -> "Wind":
        """With one gust, which adds the pressure of SPEED."""
        single = copy(self)
        object.__setattr__(single, "gust_s", time_s)
        return single

    def with_latent(self, strength: float) -> dict[str, float]:
        """Pressure goes with the square of the speed, and gusts add to its mean."""
        gusts = MOST * min(strength / max(self.latent_limit, 1e-9), 1)
        return {"mean_speed": self.values["mean_speed"] / float(np.hypot(1, gusts)), "gust_strength": gusts}

    @property
    def latent_limit(self) -> float:
        return MOST * 2 * (self.values["mean_speed"] / SPEED) ** 2

    def force(self, motion: Motion) -> Mapping[str, Array]:
        machine, joints, square = motion.boom, motion.joints, self._square(motion.time)
        blow = np.array([np.cos(self.values["direction"]), np.sin(self.values["direction"]), 0.0])
        forces, places = {}, np.array(machine.sensors.markers_x)
        for k, link in enumerate(machine.links):
            pitch = joints[:, 1 : k + 2].sum(axis=1)
            along = np.stack(
                [np.cos(joints[:, 0]) * np.cos(pitch), np.sin(joints[:, 0]) * np.cos(pitch), np.sin(pitch)], axis=1
            )
            across = blow - (along @ blow)[:, None] * along  # (n, 3)
            pressure = 0.5 * DENSITY * DRAG * (square * np.linalg.norm(across, axis=1))[:, None] * across
            area = np.interp(np.linspace(-1, 0, 101), [-1, 0], link.height) * link.length / 101  # (101,)
            for number, share in enumerate(_shares(places, np.linspace(-1, 0, 101), area)):
                forces[f"marker{len(places) * k + number + 1}"] = share * pressure
        return forces

    def _square(self, time: Array) -> Array:
        """Of the speed over time, (n,), m^2/s^2."""
        if self.gust_s is not None:
            return self.values["mean_speed"] ** 2 + SPEED**2 * np.maximum(1 - np.abs(time - self.gust_s) / KNOT_S, 0)
        return (self.values["mean_speed"] * self._gusts(time)) ** 2

    def _gusts(self, time: Array) -> Array:
        if self.values["gust_strength"] == 0 or len(time) < 2:
            return np.ones_like(time)
        step = time[1] - time[0]
        decay = np.exp(-step / CORRELATION_S)
        shocks = np.random.default_rng(len(time)).normal(size=len(time)) * np.sqrt(1 - decay**2)
        return np.maximum(1 + self.values["gust_strength"] * lfilter([1], [1, -decay], shocks), 0)

    @classmethod
    def free(cls, site: Site) -> tuple[str, ...]:
        return "mean_speed", "direction"

    @classmethod
    def screening(cls, site: Site, lines_hz: Sequence[float] = ()) -> list[list[dict[str, float]]]:
        """From in front and from the side."""
        return [[{"mean_speed": SPEED, "direction": d} for d in (0.0, np.pi / 2)]]

    @classmethod
    def combine(cls, site: Site, points: Sequence[Values], weights: Array) -> dict[str, float]:
        """Pressures add up."""
        x, y = weights
        speed = np.clip(SPEED * np.hypot(x, y) ** 0.5, 0, 40)
        return {"mean_speed": float(speed), "direction": float(np.arctan2(y, x))}


def _shares(places: Array, at: Array, load: Array) -> Array:
    """Loads on a few places with the same sum and the same moment as a distributed one, (k,)."""
    moments = np.vstack([np.ones_like(places), places])
    wanted = np.array([load.sum(), load @ at])
    return np.linalg.lstsq(moments, wanted, rcond=None)[0]
