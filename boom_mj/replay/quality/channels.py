"""What the samples of one channel say of themselves: runs of equal ones, resolution, noise, limits."""

import numpy as np
from scipy.special import erf

from boom_mj.simulation.smoothing import white_noise

Array = np.ndarray
CHANCE = 1e-9  # of a run of equal samples among noise, below which it is none
SHORTEST_RUN = 10  # samples
EQUAL = 1e-9  # of the largest value: what differs by less is rounding


def runs(values: Array, least: int) -> list[tuple[int, int]]:
    """Stretches [start, stop) of at least so many equal samples."""
    same = np.concatenate([[False], values[1:] == values[:-1], [False]]).astype(np.int8)
    edges = np.flatnonzero(np.diff(same)).reshape(-1, 2)  # from a run's first sample to its last
    return [(int(a), int(b) + 1) for a, b in edges if b + 1 - a >= least]


def resolution(values: Array) -> float:
    """Smallest step between different samples; 0 where there are fewer than two."""
    levels = np.unique(values[np.isfinite(values)])
    steps = np.diff(levels)
    steps = steps[steps > EQUAL * np.abs(levels[[0, -1]]).max()] if len(levels) > 1 else steps
    return float(steps.min()) if steps.size else 0.0


def own_noise(values: Array) -> float:
    """Standard deviation of what is white in a channel, 0 where most neighbours are equal."""
    known = values[np.isfinite(values)]
    return float(white_noise(known)) if len(known) > 2 else 0.0


def shortest_run(step: float, noise: float) -> int:
    """Samples that a run must have, so that noise read in such steps shows one with CHANCE only."""
    alike = erf(step / (2 * np.sqrt(2) * noise)) if noise > 0 else 0.0  # next sample on the same step, at best
    needed = np.log(CHANCE) / np.log(alike) if 0 < alike < 1 else (np.inf if alike >= 1 else 0.0)
    return max(SHORTEST_RUN, int(min(np.ceil(needed), 1e9)))


def limits(values: Array, noise: float) -> list[float]:
    """Ends of a channel's range on which samples pile up: least and largest values at which a converter stops.

    Below an end that is no limit samples thin out over a standard deviation of the noise; on a limit lie all that would
    have gone beyond it.
    """
    known = values[np.isfinite(values)]
    found = []
    for sign in (-1.0, 1.0):
        level, count = np.unique(sign * known, return_counts=True)
        if len(level) < FEWEST_LEVELS:
            continue
        near = count[:-1][level[:-1] > level[-1] - max(noise, 1e-300)]
        beside = near.max() if near.size else count[-6:-1].max()
        if count[-1] >= max(PILE, STEEP * beside):
            found.append(float(sign * level[-1]))
    return found


FEWEST_LEVELS = 20  # of a channel, for its last to be a limit: coarse channels have few, all of them high
PILE, STEEP = 8, 5.0  # samples on a limit, and times those on a step next to it
