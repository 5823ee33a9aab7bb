"""What would have to push: residual forces on the boom's elastic coordinates that would explain where its markers are.

With one hinge x per Ritz coordinate, Jacobian J of the markers, whitening w of their residuals r and a wide prior P,

    x(t) = (J^T w^2 J + P^-2)^-1 J^T w^2 r(t),        f(t) = M x'' + K x,

smoothed over SMOOTH seconds; J, M and K belong to the pose. The same for residuals of noise alone says which force
means nothing. A cylinder says itself what force it lacks.
"""

from collections.abc import Iterator
from typing import TYPE_CHECKING

import mujoco
import numpy as np
from scipy.ndimage import gaussian_filter1d

from boom_mj.machine import Machine
from boom_mj.simulation import Plant, make_plant
from boom_mj.systems.system import ResidualForce

if TYPE_CHECKING:
    from boom_mj.diagnosis.linearisation import Metric

Array = np.ndarray
PRIOR = 0.05  # rad, deviation of a hinge
SMOOTH = 0.2  # s
POSE = 20  # blocks for which a pose keeps its matrices
TOLD = 0.7  # of the prior deviation: what is no better known tells nothing


def pushes(machine: Machine, metric: "Metric", residual: Array) -> tuple[ResidualForce, ...]:
    """Forces that a whitened residual (N,) asks for, largest ratio first, but for those of which no marker tells."""
    found = [*_of_cylinders(metric, residual), *_of_hinges(make_plant(machine, 1), metric, residual)]
    return tuple(sorted(found, key=lambda push: -push.ratio))


def _of_cylinders(metric: "Metric", residual: Array) -> Iterator[ResidualForce]:
    channels = metric.campaign.channels
    for part in sorted({channel.group for channel in channels if channel.signal == "cylinder/force"}):
        own = metric.campaign.spread([channel.group == part for channel in channels]).astype(bool)
        rows = own & (metric.weight > 0)
        lacking, ratio = (np.sqrt(np.mean(v**2)) for v in (residual[rows] / metric.weight[rows], residual[rows]))
        yield ResidualForce(part, "force", float(lacking), "N", float(ratio))


def _of_hinges(plant: Plant, metric: "Metric", residual: Array) -> Iterator[ResidualForce]:
    campaign = metric.campaign
    noise = np.random.default_rng(0).standard_normal(len(residual))
    power, seen = np.zeros((2, len(plant.elastic))), np.zeros(len(plant.elastic))
    for index in range(len(campaign.recordings)):
        own = [k for k, c in enumerate(campaign.channels) if c.signal == "markers" and c.recording == index]
        if own:
            cut = [campaign.stretch(k) for k in own]
            weight, *white = (np.stack([v[s] for s in cut], axis=1) for v in (metric.weight, residual, noise))
            poses = campaign.subject.motion(campaign.recordings[index], campaign.channels[own[0]].time)
            forces, told = _forces(plant, poses, weight, np.stack(white), campaign.subject.block)
            power += np.where(told, (forces**2).sum(axis=1), 0.0)
            seen += told * len(weight)
    for k in np.flatnonzero(seen):
        link, axis, _ = plant.model.joint(int(plant.model.dof_jntid[plant.elastic[k]])).name.split("_")
        force, ratio = np.sqrt(power[0, k] / seen[k]), np.sqrt(power[0, k] / power[1, k])
        yield ResidualForce(link, axis, float(force), "N m", float(ratio))


def _forces(plant: Plant, poses: Array, weight: Array, white: Array, block: float) -> tuple[Array, Array]:
    """Forces (2, n, 12) on every hinge for two whitened residuals (2, n, 36) at poses (n, 5); which are told, (12,)."""
    hinges = np.zeros((*white.shape[:2], len(plant.elastic)))
    told = np.zeros(len(plant.elastic), bool)
    matrices = []
    for k in range(len(poses)):
        if k % POSE == 0:
            matrices.append(_matrices(plant, poses[k]))
        felt = weight[k][:, None] * matrices[-1][0]
        covariance = np.linalg.inv(felt.T @ felt + np.eye(len(plant.elastic)) / PRIOR**2)
        told |= np.sqrt(np.diag(covariance)) < TOLD * PRIOR
        hinges[:, k] = white[:, k] * (weight[k] > 0) @ felt @ covariance
    smooth = gaussian_filter1d(hinges, SMOOTH / block, axis=1, mode="nearest")
    bent = np.gradient(np.gradient(smooth, block, axis=1), block, axis=1)
    forces = np.empty_like(smooth)
    for number, (_, inertia, stiffness) in enumerate(matrices):
        part = np.s_[:, number * POSE : (number + 1) * POSE]
        forces[part] = bent[part] @ inertia + smooth[part] @ stiffness
    return forces, told


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
