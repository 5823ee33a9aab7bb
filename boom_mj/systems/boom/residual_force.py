"""Residual forces on the boom's elastic coordinates that would explain where its markers are.

With one hinge x per Ritz coordinate, Jacobian J of the markers, whitening w of their residuals r and a wide prior P,

    x(t) = (J^T w^2 J + P^-2)^-1 J^T w^2 r(t),        f(t) = M x'' + K x,

smoothed over SMOOTH seconds; J, M and K belong to the pose. The same for residuals of noise alone says which force
means nothing. A cylinder says itself what force it lacks.
"""

from collections.abc import Callable, Iterator, Sequence

import mujoco
import numpy as np
from scipy.ndimage import gaussian_filter1d

from boom_mj.estimation.dataset import Dataset
from boom_mj.machine import Machine
from boom_mj.simulation import Plant, make_plant
from boom_mj.systems.system import ResidualForce

Array = np.ndarray
PRIOR = 0.05  # rad, deviation of a hinge
SMOOTH = 0.2  # s
POSE = 20  # blocks for which a pose keeps its matrices
INFORMED = 0.7  # of the prior deviation: what is no better known informs nothing


def forces(
    machine: Machine, data: Dataset, poses: Sequence[Callable[[Array], Array]], white: Array, weight: Array
) -> tuple[ResidualForce, ...]:
    """Forces that a whitened residual (N,) asks for, largest ratio first, but for those that no marker informs.

    Args:
        poses: joint angles (n, 5) of every recording at times (n,).
        weight: of the residual, (N,).
    """
    found = [*_of_cylinders(data, white, weight), *_of_hinges(make_plant(machine, 1), data, poses, white, weight)]
    return tuple(sorted(found, key=lambda force: -force.ratio))


def _of_cylinders(data: Dataset, white: Array, weight: Array) -> Iterator[ResidualForce]:
    for part in sorted({channel.group for channel in data.channels if channel.signal == "cylinder/force"}):
        own = data.spread([channel.group == part for channel in data.channels]).astype(bool)
        rows = own & (weight > 0)
        if rows.any():
            lacking, ratio = (np.sqrt(np.mean(v**2)) for v in (white[rows] / weight[rows], white[rows]))
            yield ResidualForce(part, "force", float(lacking), "N", float(ratio))


def _of_hinges(
    plant: Plant, data: Dataset, poses: Sequence[Callable[[Array], Array]], residual: Array, weight: Array
) -> Iterator[ResidualForce]:
    noise = np.random.default_rng(0).standard_normal(len(residual))
    power, seen = np.zeros((2, len(plant.elastic))), np.zeros(len(plant.elastic))
    for index, pose in enumerate(poses):
        own = [k for k, c in enumerate(data.channels) if c.signal == "markers" and c.recording == index]
        if own:
            cut = [data.stretch(k) for k in own]
            scale, *white = (np.stack([v[s] for s in cut], axis=1) for v in (weight, residual, noise))
            found, informed = _forces(plant, pose(data.channels[own[0]].time), scale, np.stack(white), data.block_s)
            power += np.where(informed, (found**2).sum(axis=1), 0.0)
            seen += informed * len(scale)
    for k in np.flatnonzero(seen):
        link, axis, _ = plant.model.joint(int(plant.model.dof_jntid[plant.elastic[k]])).name.split("_")
        force, ratio = np.sqrt(power[0, k] / seen[k]), np.sqrt(power[0, k] / power[1, k])
        yield ResidualForce(link, axis, float(force), "N m", float(ratio))


def _forces(plant: Plant, poses: Array, weight: Array, white: Array, block: float) -> tuple[Array, Array]:
    """Forces (2, n, 12) on hinges for two whitened residuals (2, n, 36) at poses (n, 5); which are informed, (12,)."""
    hinges = np.zeros((*white.shape[:2], len(plant.elastic)))
    informed = np.zeros(len(plant.elastic), bool)
    matrices = []
    for k in range(len(poses)):
        if k % POSE == 0:
            matrices.append(_matrices(plant, poses[k]))
        felt = weight[k][:, None] * matrices[-1][0]
        covariance = np.linalg.inv(felt.T @ felt + np.eye(len(plant.elastic)) / PRIOR**2)
        informed |= np.sqrt(np.diag(covariance)) < INFORMED * PRIOR
        hinges[:, k] = white[:, k] * (weight[k] > 0) @ felt @ covariance
    smooth = gaussian_filter1d(hinges, SMOOTH / block, axis=1, mode="nearest")
    bent = np.gradient(np.gradient(smooth, block, axis=1), block, axis=1)
    forces = np.empty_like(smooth)
    for number, (_, inertia, stiffness) in enumerate(matrices):
        part = np.s_[:, number * POSE : (number + 1) * POSE]
        forces[part] = bent[part] @ inertia + smooth[part] @ stiffness
    return forces, informed


def _matrices(plant: Plant, angles: Array) -> tuple[Array, Array, Array]:
    """At rest at joint angles (5,): how markers move with the hinges, marker 1 first, (36, 12); M and K, (12, 12)."""
    qpos = plant.static_equilibrium(angles)
    data, turned, rows = plant.at(qpos), np.zeros((3, plant.model.nv)), {}
    world = data.site("world").xmat.reshape(3, 3)
    for site in range(plant.model.nsite):
        name = plant.model.site(site).name
        if name.startswith("marker"):
            mujoco.mj_jacSite(plant.model, data, turned, None, site)
            rows[int(name.removeprefix("marker"))] = world.T @ turned[:, plant.elastic]
    inertia = plant.mass_matrix(qpos)[np.ix_(plant.elastic, plant.elastic)]
    return np.vstack([rows[number] for number in sorted(rows)]), inertia, plant.stiffness(qpos)
