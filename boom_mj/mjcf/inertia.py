"""Rigid inertias for the bodies of a hinged link, physically consistent by construction.

A link's mass points are shared out among its bodies; whatever the shares, every body is a set of positive masses and all
bodies together are the link. With one hinge per coordinate the shares are tuned: they are the ones between 0 and 1 whose
outer body moves with the modal mass entries of the shape functions, closest to the share of slope that each point has
seen. With more hinges a point belongs to the body that it lies on.
"""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import lsq_linear

from boom_mj.machine import Machine, ritz_shapes, sections
from boom_mj.mjcf.hinges import HingeChain

Array = np.ndarray
PRIOR_WEIGHT = 1e-3  # of the natural shares against the modal mass entries


@dataclass(frozen=True)
class RigidInertia:
    """Mass (kg), centre of mass (3,) in the link-tip frame (m), inertia tensor (3, 3) about it (kg m^2)."""

    mass: float
    center: Array
    tensor: Array


def segment_inertias(machine: Machine, index: int, chains: dict[str, HingeChain]) -> tuple[RigidInertia, ...]:
    """Inertias of the bodies of one link, root outward: one more than its hinges per coordinate."""
    link, cuts = machine.links[index], segment_cuts(chains)
    x, mass, inertia = _mass_points(machine, index, cuts)
    if len(cuts) == 1:
        outer, outer_spin = _tuned_shares(machine, index, chains, x, mass, inertia)
        shares, spins = np.stack([1 - outer, outer]), np.stack([1 - outer_spin, outer_spin])
    else:
        inside = np.searchsorted(cuts, x)
        shares = spins = np.stack([inside == k for k in range(len(cuts) + 1)]).astype(float)
    position = np.stack([x, np.zeros_like(x), sections.offset(link, machine.offset_profile.kind, x) - link.offset])
    return tuple(
        _rigid(position, mass * share, float(inertia @ spin), beam_axis(machine, index))
        for share, spin in zip(shares, spins)
    )


def segment_cuts(chains: dict[str, HingeChain]) -> Array:
    """Where a link's bodies meet: midway between its bending hinges, (n,), m."""
    return np.array([(v.position + w.position) / 2 for v, w in zip(chains["v"].hinges, chains["w"].hinges)])


def beam_axis(machine: Machine, index: int) -> Array:
    """Unit vector along the neutral axis in the link frame, (3,): a ramp's beam runs from root to tip."""
    link = machine.links[index]
    rise = link.offset if machine.offset_profile.kind == "ramp" else 0.0
    return np.array([link.length, 0.0, rise]) / np.hypot(link.length, rise)


def _mass_points(machine: Machine, index: int, cuts: Array) -> tuple[Array, Array, Array]:
    """Places x, masses and rotary inertias (19), (20) of a link, with Gauss points on each stretch between cuts."""
    link, edges = machine.links[index], np.array([-machine.links[index].length, *cuts, 0.0])
    node, weight = np.polynomial.legendre.leggauss(8)
    half = np.diff(edges)[:, None] / 2
    x, weight = (edges[:-1, None] + half * (node + 1)).ravel(), (half * weight).ravel()
    points = np.array(machine.masses_on_link[index]).reshape(-1, 2)
    return (
        np.append(x, points[:, 0]),
        np.append(weight * sections.line_mass(link, x), points[:, 1]),
        np.append(weight * sections.line_rotary_inertia(link, x), np.zeros(len(points))),
    )


def _tuned_shares(
    machine: Machine, index: int, chains: dict[str, HingeChain], x: Array, mass: Array, inertia: Array
) -> tuple[Array, Array]:
    """Shares of mass and of rotary inertia that move with the outer body."""
    link, shapes = machine.links[index], ritz_shapes(machine)[index]
    rows, targets, prior = [], [], np.zeros_like(x)
    for axis in ("v", "w"):
        shape, hinge = shapes[axis], chains[axis].hinges[0]
        swing, lever = hinge.gain * (x - hinge.position), x + link.length
        for row, target in (
            (mass * swing, mass @ shape(x)),
            (mass * swing * lever, mass @ (shape(x) * lever)),
            (mass * swing**2, mass @ shape(x) ** 2),
        ):
            rows.append(row / target)
            targets.append(1.0)
        prior += np.clip(shape.slope(x) / hinge.gain, 0, 1) / 2
    rows.append(PRIOR_WEIGHT * np.eye(x.size))
    targets.append(PRIOR_WEIGHT * prior)
    shares = lsq_linear(np.vstack(rows), np.hstack(targets), (0, 1), tol=1e-12).x
    twist = shapes["torsion"](x)
    return shares, twist**2  # meets the self entry of the twist


def _rigid(position: Array, mass: Array, inertia: float, axis: Array) -> RigidInertia:
    total = float(mass.sum())
    center = position @ mass / total
    r = position - center[:, None]
    spread = (r * mass) @ r.T
    tensor = np.trace(spread) * np.eye(3) - spread
    across = (np.eye(3) - np.outer(axis, axis)) * max(0.0, 0.505 * inertia - np.trace(spread))
    return RigidInertia(total, center, tensor + inertia * np.outer(axis, axis) + across)
