"""A simulation that diverged: when, where, and what it did before."""

from dataclasses import dataclass

import mujoco
import numpy as np

from boom_mj.errors import SimulationError

Array = np.ndarray
KEPT = 200  # states
WILD = 100.0  # rad/s or m/s, which no part of a machine reaches


@dataclass(frozen=True)
class LastStates:
    """The last states that were numbers, oldest first.

    Attributes:
        time: (n,), s.
        coordinates: names of joints and hinges by entry of qvel, (nv,).
        qpos: (n, nq).
        qvel: (n, nv).
    """

    time: Array
    coordinates: tuple[str, ...]
    qpos: Array
    qvel: Array

    def table(self) -> str:
        """The states as CSV: time, positions, then speeds."""
        plain = self.qpos.shape[1] == len(self.coordinates)
        positions = self.coordinates if plain else tuple(f"qpos{k}" for k in range(self.qpos.shape[1]))
        names = ["time_s", *positions, *(f"{name}_speed" for name in self.coordinates)]
        rows = np.column_stack([self.time, self.qpos, self.qvel])
        return "\n".join([",".join(names), *(",".join(f"{x:.9g}" for x in row) for row in rows)]) + "\n"


def diverged(model: mujoco.MjModel, qpos: Array, qvel: Array, warning: Array, machine: str) -> SimulationError:
    """What to raise about a simulation whose states are no longer numbers.

    Args:
        qpos, qvel: states after 0, 1, .. steps, (n, nq) and (n, nv).
        warning: MuJoCo's: what it was about last, and how often, by kind, (k, 2).
    """
    whole = np.isfinite(qpos).all(axis=1) & np.isfinite(qvel).all(axis=1) & (np.abs(qvel).max(axis=1) < mujoco.mjMAXVAL)
    end = len(whole) if whole.all() else int(np.argmin(whole))
    names = tuple(model.joint(k).name or f"joint {k}" for k in model.dof_jntid)
    size = np.abs(qvel[:end])
    wild: Array = np.flatnonzero(size.max(axis=1, initial=0) > WILD)
    if len(wild):
        dof, speed = int(np.argmax(size[wild[0]])), f" at {size[wild[0]].max():.3g} rad/s or m/s"
    else:  # at once: MuJoCo names the coordinate that it could not go on with
        told = warning[warning[:, 1] > 0]
        dof, speed = int(told[0, 0]) if len(told) and told[0, 0] < model.nv else 0, ""
    when = model.opt.timestep * (wild[0] if len(wild) else end)
    body = model.body(model.dof_bodyid[dof]).name
    first = max(0, end - KEPT)
    states = LastStates(model.opt.timestep * np.arange(first, end), names, qpos[first:end], qvel[first:end])
    return SimulationError(
        f"the simulation of {machine} left the numbers at about t = {when:.3f} s: {names[dof]} of {body or 'its body'} "
        f"went first{speed}",
        states,
    )
