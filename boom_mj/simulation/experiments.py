"""Experiments: a start pose, moves of joints, and a rope load that is cut; the catalogue and one's own from TOML."""

import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, FiniteFloat, ValidationError

from boom_mj.errors import ExperimentError
from boom_mj.machine import Machine

Array = np.ndarray
RELEASE_TIME = 0.02  # s in which a cut rope's force falls to zero
Joint = Annotated[int, Field(ge=1, le=5)]
Positive = Annotated[FiniteFloat, Field(gt=0)]
NonNegative = Annotated[FiniteFloat, Field(ge=0)]


class _Frozen(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")


class Move(_Frozen):
    """A joint turns by an angle: speed rises and falls along half a cosine of `blend` seconds."""

    joint: Joint
    start: NonNegative
    angle_deg: FiniteFloat
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
    pose_deg: tuple[FiniteFloat, FiniteFloat, FiniteFloat, FiniteFloat, FiniteFloat]
    duration: Positive
    load: tuple[FiniteFloat, FiniteFloat, FiniteFloat] = (0.0, 0.0, 0.0)
    release: Positive | None = None
    move: tuple[Move, ...] = ()
    chirp: tuple[Chirp, ...] = ()

    def joint_path(self, time: Array) -> tuple[Array, Array, Array]:
        """Reference angle (rad), velocity and acceleration of joints 1-5 at the given times, each (n, 5)."""
        path = np.zeros((3, len(time), 5))
        path[0] = np.radians(self.pose_deg)
        for motion in (*self.move, *self.chirp):
            path[:, :, motion.joint - 1] += motion.path(np.asarray(time, float))
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
            limits = (("angle", angle[:, k], drive.range_deg), ("speed", velocity[:, k], (-drive.max_speed_deg_s, drive.max_speed_deg_s)))  # fmt: skip  # noqa: E501
            for what, values, (low, high) in limits:
                shown = np.degrees(values)
                bad = np.flatnonzero((shown < low - 1e-6) | (shown > high + 1e-6))
                if bad.size:
                    raise ExperimentError(
                        f"experiment {self.name}: joint{k + 1} {what} {shown[bad[0]]:.2f} at t = {time[bad[0]]:.2f} s is "
                        f"outside [{low:g}, {high:g}] of {machine.name} (deg, s)"
                    )


STRETCHED, BOW, T_SHAPE = (0.0, 0.0, 0.0, 0.0, 0.0), (0.0, 60.0, -35.0, -40.0, -45.0), (0.0, 85.0, -85.0, 0.0, 0.0)


def _release(name: str, pose: tuple, load: tuple, text: str) -> Experiment:
    return Experiment(name=name, description=text, pose_deg=pose, duration=30, load=load, release=8.0)


def _there_and_back(joint: int, start: float, angle: float, speed: float) -> tuple[Move, ...]:
    moves = []
    for turn in (angle, -2 * angle, angle):
        moves.append(Move(joint=joint, start=start, angle_deg=turn, speed_deg_s=speed, blend=0.8))
        start += moves[-1].duration
    return tuple(moves)


def _moves(rows: tuple[tuple[int, float, float, float, float], ...]) -> tuple[Move, ...]:
    return tuple(Move(joint=j, start=t, angle_deg=a, speed_deg_s=v, blend=b) for j, t, a, v, b in rows)


CATALOGUE: Mapping[str, Experiment] = {
    e.name: e
    for e in (
        _release("release_stretched_vertical", STRETCHED, (0, 0, -981), "stretched, 100 kg on a rope, cut at 8 s"),
        _release("release_stretched_horizontal", STRETCHED, (0, 981, 0), "stretched, 100 kg over a pulley, cut at 8 s"),
        _release("release_bow_vertical", BOW, (0, 0, -981), "bow pose, 100 kg on a rope, cut at 8 s"),
        _release("release_bow_horizontal", BOW, (0, 981, 0), "bow pose, 100 kg over a pulley, cut at 8 s"),
        _release("release_stretched_vertical_half", STRETCHED, (0, 0, -490.5), "stretched, 50 kg on a rope, cut at 8 s"),
        Experiment(
            name="slew_t", description="T pose, joint 1 moves 6 deg in 4 s and stops", pose_deg=T_SHAPE, duration=30,
            move=_moves(((1, 3.0, 6.0, 2.0, 1.0),)),
        ),
        Experiment(
            name="sweep", description="bow pose, joints 2 and 3 slowly +-5 deg with reversals, then slewing", pose_deg=BOW,
            duration=60, move=_there_and_back(2, 1.5, 5, 1) + _there_and_back(3, 20.5, 5, 1) + _there_and_back(1, 44, 5, 2),
        ),
        Experiment(
            name="fold_in", description="from the bow pose to the folded transport pose, then rest", pose_deg=BOW,
            duration=80, move=_moves(((5, 1.5, -125, 4.8, 2.5), (4, 4, -130, 4.2, 2.5), (3, 11, -130, 2.9, 2.5), (2, 40, -25, 1.4, 2))),
        ),
        Experiment(
            name="fold_in_300", description="the fold-in with long holds and one joint after the other, 300 s", pose_deg=BOW,
            duration=300, move=_moves((
                (1, 10, 20, 1.0, 2), (5, 40, -60, 2.4, 2), (4, 70, -60, 2.2, 2), (5, 105, -65, 2.4, 2), (4, 140, -70, 2.2, 2),
                (3, 160, -130, 2.0, 2.5), (1, 200, -20, 1.0, 2), (2, 240, -25, 1.0, 2),
            )),
        ),
        Experiment(
            name="mixed", description="stop-and-go moves of all joints, slewing included", pose_deg=(-4, 62, -50, -5, -15),
            duration=60, move=_moves((
                (1, 3, 8, 1.8, 1.7), (5, 5, -24, 3, 1.6), (2, 10, 7, 1, 1.6), (3, 14, -10, 1.8, 1.8), (4, 20, -16, 2.6, 1.8),
                (1, 23.1, -6, 1.8, 1.7), (5, 23.6, 16, 3, 1.6), (2, 30.6, -5, 1, 1.6), (3, 34.3, 6, 1.8, 1.8), (4, 38.9, 10, 2.6, 1.8),
                (5, 39.5, -12, 3, 1.6),
            )),
        ),
        Experiment(
            name="chirp_joint2", description="stretched, joint 2 swings 0.1 deg from 0.1 to 1.1 Hz", pose_deg=STRETCHED,
            duration=30, chirp=(Chirp(joint=2, start=1, duration=27, amplitude_deg=0.1, frequencies_hz=(0.1, 1.1)),),
        ),
        Experiment(
            name="chirp_joint4", description="bow pose, joint 4 swings 0.3 deg from 0.1 to 1.3 Hz", pose_deg=BOW,
            duration=30, chirp=(Chirp(joint=4, start=1, duration=27, amplitude_deg=0.3, frequencies_hz=(0.1, 1.3)),),
        ),
        Experiment(
            name="slew_tour", description="bow pose, holds at slewing 0, 90 and 180 deg", pose_deg=BOW, duration=120,
            move=_moves(((1, 12, 90, 2.6, 2), (1, 62, 90, 2.6, 2))),
        ),
        Experiment(
            name="hold", description="bow pose, 60 s with 100 kg on a rope, 60 s without", pose_deg=BOW, duration=120,
            load=(0, 0, -981), release=60.0,
        ),
    )
}  # fmt: skip


def load_experiment(name: str) -> Experiment:
    """An experiment by its name in the catalogue, or from a TOML file with the fields of `Experiment`.

    Raises:
        ExperimentError: neither a known name nor a good file.
    """
    if name in CATALOGUE:
        return CATALOGUE[name]
    if not name.endswith(".toml"):
        raise ExperimentError(f"no experiment {name!r}; known: {', '.join(CATALOGUE)}; or a .toml file of your own")
    try:
        return Experiment.model_validate({"name": Path(name).stem, **tomllib.loads(Path(name).read_text())})
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise ExperimentError(f"{name}: cannot be read as an experiment ({error})") from error
    except ValidationError as error:
        places = "; ".join(f"{'.'.join(map(str, e['loc']))} = {e['input']!r}: {e['msg']}" for e in error.errors())
        raise ExperimentError(f"{name}: {places}") from error
