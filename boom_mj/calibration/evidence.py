"""What was measured, as one long vector, and what a machine would have given.

Every setting (a machine and zero offsets) is simulated at most once per recording and number of hinges, on threads.
Refining the hinges from HINGES to FINEST changes the prediction by what ever finer ones would, and a share of it counts
as the model's own error.
"""

import os
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from threading import Lock

import numpy as np
from scipy.ndimage import maximum_filter1d

from boom_mj.calibration.parameters import Setting
from boom_mj.effects import effects_of
from boom_mj.errors import BoomError, LogError
from boom_mj.machine import Machine
from boom_mj.mjcf import build
from boom_mj.recording import Recording
from boom_mj.sensors import driving_angles, ideal_signals, noise_levels, sample, true_angles
from boom_mj.sensors.blocks import blocks_of
from boom_mj.simulation import Plant, Trajectory, run, step_times
from boom_mj.simulation.plant import with_effects

Array = np.ndarray
COARSE, HINGES, FINEST = 2, 3, 4  # hinges of secants, of what is compared with the measurements, of its correction
PACE = 2.0  # steps of secants, in those of the plant
LEFT = 0.5  # share of that change that may be wrong
REACH = 5  # blocks over which the model's error is carried, for phase
KEPT = 8  # plants


class Evidence:
    """Recordings of a machine and a cache of simulations of them.

    Args:
        machine: for rates and noise.
        recordings: whose joint angles drive the model.
        threads: simulations at a time.

    Raises:
        LogError: there is no recording, or nothing in one to compare.
    """

    def __init__(self, machine: Machine, recordings: Sequence[Recording], threads: int | None = None):
        if not recordings:
            raise LogError("a calibration needs at least one recording")
        self.blocks = tuple(blocks_of(machine, log) for log in recordings)
        self.measured = np.concatenate([b.mean.ravel() for b in self.blocks])  # (N,)
        self.noise = np.concatenate([b.noise.ravel() for b in self.blocks])
        self.used = np.isfinite(self.measured)
        self.recording_of = np.repeat(np.arange(len(self.blocks)), [b.mean.size for b in self.blocks])
        self.time = np.concatenate([np.repeat(b.time, b.mean.shape[1]) for b in self.blocks])
        self.simulated_s = 0.0
        self._joint_noise = noise_levels(machine)["joint/position"][0]
        self._pool = ThreadPoolExecutor(threads or os.cpu_count() or 1)
        self._lock = Lock()
        self._done: dict[tuple, Array] = {}
        self._inputs: dict[tuple[int, int], tuple[Array, Array]] = {}
        self._plants: dict[tuple, Plant] = {}

    @property
    def groups(self) -> Array:
        """Channel group of every entry, (N,) of str."""
        return np.concatenate([np.tile([c.group for c in b.columns], len(b.time)) for b in self.blocks])

    def predict(self, settings: Sequence[Setting], hinges: int, pace: float = 1.0) -> list[Array]:
        """The long vector of every setting, (N,) each; NaN where MuJoCo left the numbers.

        Args:
            pace: steps of the integrator in those of the plant.
        """
        indices = range(len(self.blocks))
        futures = [[self._pool.submit(self._part, setting, hinges, pace, k) for k in indices] for setting in settings]
        return [np.concatenate([part.result() for part in row]) for row in futures]

    def _part(self, setting: Setting, hinges: int, pace: float, index: int) -> Array:
        key = (setting, hinges, pace, index)
        if key not in self._done:
            try:
                self._done[key] = (
                    self.blocks[index].of(ideal_signals(self.motion(setting, hinges, index, pace))).ravel()
                )
            except BoomError:
                self._done[key] = np.full(self.blocks[index].mean.size, np.nan)
        return self._done[key]

    def motion(self, setting: Setting, hinges: int, index: int, pace: float = 1.0) -> Trajectory:
        """The simulated motion of one recording."""
        plant = self._plant(setting, hinges, pace)
        block = self.blocks[index]
        joints = block.log["joint/position"]
        steps = step_times(plant, joints.time[-1] - joints.time[0])
        reading, force = self._driven(index, steps)
        motion = run(plant, true_angles((*plant.effects, setting.sensor), reading), force)
        with self._lock:
            self.simulated_s += float(steps[-1])
        return motion

    def _plant(self, setting: Setting, hinges: int, pace: float) -> Plant:
        key = (setting.machine, hinges, pace)
        with self._lock:
            if key not in self._plants:
                while len(self._plants) >= KEPT:
                    self._plants.pop(next(iter(self._plants)))
                boom = build(setting.machine, hinges)
                boom.spec.option.timestep *= pace
                self._plants[key] = with_effects(boom, effects_of(setting.machine))
            plant = self._plants[key]
        return Plant(plant.boom, plant.model, plant.effects)  # its scratch is its own

    def _driven(self, index: int, steps: Array) -> tuple[Array, Array]:
        """Smooth joint readings and the known load at the steps of the simulation."""
        key, log = (index, len(steps)), self.blocks[index].log
        if key not in self._inputs:
            at = steps + self.blocks[index].start
            force = sample(log["load"], at) if "load" in log else np.zeros((len(at), 3))
            self._inputs[key] = driving_angles(log, self._joint_noise, at), force
        return self._inputs[key]

    def fidelity(self, setting: Setting) -> tuple[Array, Array]:
        """What finer hinges would add to the prediction, (N,), and the weight 1 / deviation of every entry, (N,)."""
        usual, fine = (self.predict([setting], hinges)[0] for hinges in (HINGES, FINEST))
        change = fine - usual
        size, first = np.empty_like(change), 0
        for block in self.blocks:
            part = slice(first, first := first + block.mean.size)
            shaped = np.abs(np.nan_to_num(change[part])).reshape(block.mean.shape)
            size[part] = maximum_filter1d(shaped, 2 * REACH + 1, axis=0, mode="nearest").ravel()
        weight = np.where(self.used, 1 / np.sqrt(self.noise**2 + (LEFT * size) ** 2), 0.0)
        return change, weight
