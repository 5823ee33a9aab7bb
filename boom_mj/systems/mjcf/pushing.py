"""What effects push a joint of an MJCF machine with, as it moves."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import mujoco
import numpy as np

from boom_mj.effects import ForceEffect, Motion

Array = np.ndarray
Exertion = Callable[[Array, Array, Array], Array]


def exertion(spec: mujoco.MjSpec, actuator: str) -> Exertion:
    """What an actuator exerts on its joint, (..., n), by command, position and speed: a set point is no force.

    MuJoCo's gear (gain u + bias_0 + bias_1 length + bias_2 velocity), without the actuator's own dynamics.
    """
    found = spec.actuator(actuator)
    gear, gain = float(found.gear[0]), float(found.gainprm[0])
    affine = found.biastype == mujoco.mjtBias.mjBIAS_AFFINE
    constant, stiffness, damping = map(float, found.biasprm[:3] if affine else np.zeros(3))
    return lambda command, position, speed: (
        gear * (gain * command + constant + gear * (stiffness * position + damping * speed))
    )


@dataclass(frozen=True, eq=False)
class Push:
    """What effects push a joint with, in one stretch or, with an axis before that of time, in several.

    Attributes:
        motors: its actuators, and their commands at all times, (..., n).
        warm: its temperature at all times, (..., n), None where that is not logged.
    """

    joint: str
    effects: Sequence[ForceEffect]
    motors: tuple[tuple[Exertion, Array], ...]
    warm: Array | None

    def __call__(self, time: Array, position: Array, speed: Array, load: Array | None = None, first: int = 0) -> Array:
        """The force, (..., n).

        Args:
            time: of the motion, (n,).
            load: what the joint's actuators exert, that of their commands if left out.
            first: number of the first of these times among all.
        """
        cut = slice(first, first + len(time))
        load = self.load(position, speed, first) if load is None else load
        warm = {} if self.warm is None else {self.joint: self.warm[..., cut]}
        moving = Motion(time, {self.joint: position}, {self.joint: speed}, {self.joint: load}, warm)
        return sum((effect.force(moving)[self.joint] for effect in self.effects), np.zeros_like(position))

    def load(self, position: Array, speed: Array, first: int = 0) -> Array:
        """What the joint's actuators exert by their commands, (..., n), from some moment on."""
        cut = slice(first, first + position.shape[-1])
        return sum((exert(u[..., cut], position, speed) for exert, u in self.motors), np.zeros_like(position))

    @property
    def remembers(self) -> bool:
        """Whether the last force depends on more than the last two moments and what filters keep."""
        return any(effect.remembers for effect in self.effects)


def together(pushes: Sequence[Push], count: int) -> Push:
    """Of one joint in several stretches, of so many steps, and a moment before the first; what is shorter stays."""

    def stacked(rows: Sequence[Array]) -> Array:
        return np.stack([np.pad(row, (1, count - len(row)), mode="edge") for row in rows])

    motors = [(motor[0][0], stacked([u for _, u in motor])) for motor in zip(*(push.motors for push in pushes))]
    warm = [push.warm for push in pushes if push.warm is not None]
    return replace(pushes[0], motors=tuple(motors), warm=stacked(warm) if warm else None)
