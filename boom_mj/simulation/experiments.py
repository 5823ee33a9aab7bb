"""Experiments: a start pose, moves of joints, and a rope load that is cut."""

from pathlib import Path
from typing import Annotated

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, FiniteFloat, ValidationError

from boom_mj.errors import ExperimentError, shown
from boom_mj.files import parse_toml, read_text
from boom_mj.machine import Machine
from boom_mj.machine.fields import NonNegative, Number, Positive

Array = np.ndarray
LONGEST = 7200.0  # s of one simulation
RELEASE_TIME = 0.02  # s in which a cut rope's force falls to zero
Joint = Annotated[int, Field(ge=1, le=5)]


class _Frozen(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")


class Move(_Frozen):
    """A joint turns by an angle: speed rises and falls along half a cosine of `blend` seconds."""

    joint: Joint
    start: NonNegative
    angle_deg: Number
    speed_deg_s: Positive
    blend: Positive = 1.0

    def path(self, time: Array) -> tuple[Array, Array, Array]:
        """Angle, velocity and acceleration of this motion alone, each (n,), rad."""
        angle = np.radians(self.angle_deg)
        speed = np.sign(angle) * min(np.radians(self.speed_deg_s), abs(angle) / self.blend)
        cruise = angle / speed - self.blend if speed else 0.0
        rise, fall = self.start, self.start + self.blend + cruise
        up = np.clip((time - rise) / self.blend, 0, 1)
        down = np.clip((time - fall) / self.blend, 0, 1)
        moving = [0.5 * (s - np.sin(np.pi * s) / np.pi) * self.blend for s in (up, down)]
        steady = [np.maximum(time - t - self.blend, 0.0) for t in (rise, fall)]
        position = speed * ((moving[0] + steady[0]) - (moving[1] + steady[1]))
        velocity = speed * 0.5 * (np.cos(np.pi * down) - np.cos(np.pi * up))
        bump = [np.sin(np.pi * s) * ((s > 0) & (s < 1)) for s in (up, down)]
        return position, velocity, speed * 0.5 * np.pi / self.blend * (bump[0] - bump[1])

    @property
    def duration(self) -> float:
        return max(abs(self.angle_deg) / self.speed_deg_s, self.blend) + self.blend


class Chirp(_Frozen):
    """A joint swings with a frequency that rises linearly; fades in and out over `fade` seconds."""

    joint: Joint
    start: NonNegative
    duration: Positive
    amplitude_deg: Positive
    frequencies_hz: tuple[Positive, Positive]
    fade: Positive = 2.0

    def path(self, time: Array) -> tuple[Array, Array, Array]:
        """Angle, velocity and acceleration of this motion alone, each (n,), rad."""
        low, high = self.frequencies_hz
        t = np.clip(time - self.start, 0, self.duration)
        rate = (high - low) / self.duration
        phase, omega, alpha = 2 * np.pi * (low * t + rate * t**2 / 2), 2 * np.pi * (low + rate * t), 2 * np.pi * rate
        up, down = np.clip(t / self.fade, 0, 1), np.clip((self.duration - t) / self.fade, 0, 1)
        w = [s**3 * (10 - 15 * s + 6 * s**2) for s in (up, down)]
        dw = [30 * s**2 * (1 - s) ** 2 * sign / self.fade for s, sign in ((up, 1), (down, -1))]
        ddw = [60 * s * (1 - s) * (1 - 2 * s) / self.fade**2 for s in (up, down)]
        a, da, dda = w[0] * w[1], dw[0] * w[1] + w[0] * dw[1], ddw[0] * w[1] + 2 * dw[0] * dw[1] + w[0] * ddw[1]
        size, s, c = np.radians(self.amplitude_deg), np.sin(phase), np.cos(phase)
        velocity = da * s + a * omega * c
        acceleration = dda * s + 2 * da * omega * c + a * (alpha * c - omega**2 * s)
        return size * a * s, size * velocity, size * acceleration


class Experiment(_Frozen):
    """What is done to the machine. It starts at rest under its load; the rope is cut at `release`."""

    name: str
    description: str = ""
    pose_deg: tuple[Number, Number, Number, Number, Number]
    duration: Annotated[FiniteFloat, Field(gt=0, le=LONGEST)]
    load: tuple[Number, Number, Number] = (0.0, 0.0, 0.0)
    release: Positive | None = None
    move: tuple[Move, ...] = ()
    chirp: tuple[Chirp, ...] = ()

    def joint_path(self, time: Array) -> tuple[Array, Array, Array]:
        """Reference angle (rad), velocity and acceleration of joints 1-5 at increasing times, each (n, 5)."""
        path = np.zeros((3, len(time), 5))
        path[0] = np.radians(self.pose_deg)
        motions: tuple[Move | Chirp, ...] = (*self.move, *self.chirp)
        for motion in motions:
            stop = motion.start + motion.duration
            first, last = np.searchsorted(time, (motion.start, stop))
            moved = np.array(motion.path(np.append(time[first:last], stop)))
            path[:, first:last, motion.joint - 1] += moved[:, :-1]
            path[:, last:, motion.joint - 1] += moved[:, -1:]
        return path[0], path[1], path[2]

    def tip_force(self, time: Array) -> Array:
        """Rope force on the tip, world frame, (n, 3), N."""
        share = np.ones(len(time))
        if self.release is not None:
            share = np.clip(1 - (np.asarray(time) - self.release) / RELEASE_TIME, 0, 1)
        return share[:, None] * np.array(self.load)

    def check(self, machine: Machine) -> None:
        """Raises ExperimentError where the machine cannot follow: joint, time, value and limit are named."""
        time = np.arange(0, self.duration + 0.005, 0.01)
        angle, velocity, _ = self.joint_path(time)
        for k, drive in enumerate(machine.drives):
            speed_limit = drive.max_speed_deg_s
            limits = (("angle", angle, drive.range_deg), ("speed", velocity, (-speed_limit, speed_limit)))
            for what, values, (low, high) in limits:
                shown = np.degrees(values[:, k])
                bad = np.flatnonzero((shown < low - 1e-6) | (shown > high + 1e-6))
                if bad.size:
                    raise ExperimentError(
                        f"experiment {self.name}: joint{k + 1} {what} {shown[bad[0]]:.2f} at t = {time[bad[0]]:.2f} s "
                        f"is outside [{low:g}, {high:g}] of {machine.name} (deg, s)"
                    )


def parse_experiment(path: str) -> Experiment:
    """An experiment from a TOML file with the fields of `Experiment`.

    Raises:
        ExperimentError: the file cannot be read or has bad fields; each is named.
    """
    content = parse_toml(read_text(path, ExperimentError), path, ExperimentError)
    try:
        return Experiment.model_validate({"name": Path(path).stem, **content})
    except ValidationError as error:
        places = "; ".join(f"{'.'.join(map(str, e['loc']))} = {shown(e['input'])}: {e['msg']}" for e in error.errors())
        raise ExperimentError(f"{path}: {places}") from error
