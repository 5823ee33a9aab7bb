"""A calibrated machine against measurements, as the paper shows it: stationary differences and first frequencies.

Simulated twins pass through the same evaluation as the recordings: the fall of marker 12 in the direction of the load that
went, and the frequency of the strongest mode of what follows.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from boom_mj.calibration.decay import fit_decay
from boom_mj.calibration.evidence import HINGES, Evidence
from boom_mj.calibration.parameters import Setting
from boom_mj.calibration.release import SETTLED, release_of, stop_of
from boom_mj.sensors import ideal_signals
from boom_mj.sensors.blocks import Blocks
from boom_mj.simulation import Plant, Trajectory, make_plant

Array = np.ndarray
LAST_MARKER = slice(-3, None)


@dataclass(frozen=True)
class Comparison:
    """One experiment: measured, and with each of some machines.

    Attributes:
        name: of the experiment.
        direction: "vertical" or "horizontal" for a load that is cut, "slewing" for a motion that stops.
        fall: stationary difference of marker 12 along the load, (1 + machines,), m; NaN without a load.
        frequency: of the strongest mode, (1 + machines,), Hz.
        damping_ratio: of that mode, (1 + machines,).
    """

    name: str
    direction: str
    fall: Array
    frequency: Array
    damping_ratio: Array

    def off(self, values: Array) -> Array:
        """Relative errors of the machines, (machines,)."""
        return values[1:] / values[0] - 1


@dataclass(frozen=True, eq=False)
class Twin:
    """A simulated recording."""

    motion: Trajectory
    blocks: Blocks


def twin(evidence: Evidence, setting: Setting, index: int, hinges: int = HINGES) -> Twin:
    """What a machine would have given in a recording."""
    motion = evidence.motion(setting, hinges, index)
    blocks = evidence.blocks[index]
    return Twin(motion, replace(blocks, mean=blocks.of(ideal_signals(motion))))


def compare_experiments(
    evidence: Evidence, settings: Sequence[Setting], twins: Sequence[Sequence[Twin]]
) -> tuple[Comparison, ...]:
    """Every recording that ends a load, or a motion, with enough time behind it.

    Args:
        settings: of the machines; the last says near which frequencies to look.
        twins: per recording, one of every machine.
    """
    plant = make_plant(settings[-1].machine, HINGES)
    found = []
    for index, blocks in enumerate(evidence.blocks):
        row = _release(plant, index, [blocks, *(t.blocks for t in twins[index])])
        row = row or _stop(plant, [blocks, *(t.blocks for t in twins[index])])
        found += [row] if row else []
    return tuple(found)


def _release(plant: Plant, index: int, all_blocks: Sequence[Blocks]) -> Comparison | None:
    releases = [release_of(blocks, index, plant) for blocks in all_blocks]
    if releases[0] is None:
        return None
    load = releases[0].before.load
    along = load / np.linalg.norm(load)
    return Comparison(
        name=releases[0].name,
        direction="vertical" if abs(along[2]) > 0.5 else "horizontal",
        fall=np.array([-release.fall[LAST_MARKER] @ along for release in releases if release]),
        frequency=np.array([release.first[0] for release in releases if release]),
        damping_ratio=np.array([release.first[1] for release in releases if release]),
    )


def _stop(plant: Plant, all_blocks: Sequence[Blocks]) -> Comparison | None:
    """The vibration after a joint 1 that stops."""
    blocks = all_blocks[0]
    stop = stop_of(blocks)
    if stop is None or blocks.time[-1] - stop < 10.0:
        return None
    joints = blocks.log["joint/position"].values[-50:].mean(axis=0)
    rest = plant.static_equilibrium(joints)
    modes = plant.modes(rest)
    pushed = plant.mass_matrix(rest)[np.ix_(plant.elastic, plant.joints[:1])][:, 0]
    strongest = np.argsort(-np.abs(modes.shape.T @ pushed))[:2]
    rows = blocks.time > stop + SETTLED
    fits = [
        fit_decay(
            b.time[rows] - stop, b.mean[rows], b.noise[rows], modes.frequency[strongest], modes.damping_ratio[strongest[0]]
        )
        for b in all_blocks
    ]
    none = np.full(len(fits), np.nan)
    first = [int(np.argmin(np.abs(np.log(fit.frequency / modes.frequency[strongest[0]])))) for fit in fits]
    return Comparison(
        name=blocks.log.name,
        direction="slewing",
        fall=none,
        frequency=np.array([fit.frequency[k] for fit, k in zip(fits, first)]),
        damping_ratio=np.array([fit.damping_ratio[k] for fit, k in zip(fits, first)]),
    )
