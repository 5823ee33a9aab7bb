"""How plainly an effect shows: what an oracle that knows the machine to the last bolt would see above the noise.

The change that an effect makes in a coarse model, in units of the noise of block means, less what could as well be how
any healthy machine differs from its file, its nuisances within their limits, as root mean square over all
channels of all experiments. It says nothing about any diagnosis.
"""

from collections.abc import Sequence
from functools import cached_property

import numpy as np
from scipy.linalg import cholesky

from boom_mj.effects import Effect, effects_of
from boom_mj.estimation.blocks import block_means
from boom_mj.estimation.linear import within_limits
from boom_mj.machine import Machine
from boom_mj.mjcf import build
from boom_mj.sensors import ideal_signals, noise_levels, sample_rates, true_angles
from boom_mj.simulation import Experiment, Plant, run, step_times
from boom_mj.simulation.plant import with_effects
from boom_mj.systems.boom.nuisances import nuisances
from boom_mj.systems.boom.system import BLOCK_S, COARSE

Array = np.ndarray


class Detectability:
    """An oracle's view of some experiments on a machine."""

    def __init__(self, machine: Machine, experiments: Sequence[Experiment]):
        self.machine, self.experiments = machine, tuple(experiments)
        self.boom = build(machine, COARSE.hinges, drawn=False)
        self.boom.spec.option.timestep *= COARSE.step
        self.healthy = self._seen(())

    @cached_property
    def columns(self) -> Array:
        """What nuisances change per prior deviation, B, (N, m)."""
        return np.stack([(self._seen(n.hypothesis) - self.healthy) * n.deviation for n in nuisances()], axis=1)

    @cached_property
    def _root(self) -> Array:
        """Upper root of 1 + B^T B, (m, m)."""
        return cholesky(np.eye(self.columns.shape[1]) + self.columns.T @ self.columns)

    def visibility(self, effects: Sequence[Effect]) -> float:
        """Root mean square of what effects change beyond nuisances, in deviations of the noise.

        Raises:
            EquilibriumError, SimulationError: the machine does not stand these effects.
        """
        change = self._seen(effects) - self.healthy
        return float(np.sqrt(np.mean((change - self.columns @ self.imitated(change)) ** 2)))

    def imitated(self, change: Array) -> Array:
        """Nuisances that explain most of a change of what is `told`, in prior deviations, (m,)."""
        return np.asarray(within_limits(self._root, self.columns.T @ change))

    def _seen(self, effects: Sequence[Effect]) -> Array:
        return self.told(with_effects(self.boom, (*effects_of(self.machine), *effects)), effects)

    def told(self, plant: Plant, effects: Sequence[Effect]) -> Array:
        """All noisy channels of a plant but the joints' own, averaged over blocks and over their noise, (N,).

        Args:
            effects: of the plant, as far as they move joints or what is said of them.
        """
        levels, rates, parts = noise_levels(self.machine), sample_rates(self.machine), []
        for experiment in self.experiments:
            time = step_times(plant, experiment.duration)
            path = true_angles(effects, experiment.joint_path(time)[0])
            signals = ideal_signals(run(plant, path, experiment.tip_force(time)))
            for name in levels:
                if name != "joint/position":
                    noise = levels[name] / np.sqrt(rates[name] * BLOCK_S)
                    parts += [
                        block_means(time, column, BLOCK_S)[2] / n for column, n in zip(signals[name].values.T, noise)
                    ]
        return np.concatenate(parts)
