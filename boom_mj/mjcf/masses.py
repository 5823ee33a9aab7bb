"""How the masses of a link are shared out among its bodies.

Every body is a set of positive masses on the link's axis, and all bodies together have the link's mass, centre and
second moment. With one hinge per coordinate the masses are tuned: those whose outer body moves with the modal mass
entries of the shape functions. With more hinges every mass belongs to the body that it lies on.
"""

import numpy as np
from scipy.optimize import nnls

from boom_mj.machine import Elastic, ritz_shapes, sections
from boom_mj.mjcf.hinges import HingeChain

Array = np.ndarray
GRID = 33  # places along a link where tuned masses may sit
EXACT = 1e5  # weight of the link's own mass and moments against the modal mass entries
PRIOR_WEIGHT = 1e-3


def mass_points(machine: Elastic, index: int, cuts: Array) -> tuple[Array, Array, Array]:
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


def tuned_masses(
    machine: Elastic, index: int, chains: dict[str, HingeChain], x: Array, mass: Array
) -> tuple[tuple[Array, Array], tuple[Array, Array]]:
    """Masses (places, kg) for the inner and the outer body of a link with one hinge per coordinate.

    Non-negative masses on a grid of places, together with the mass, first and second moment of the link; the outer ones
    meet the modal mass entries int m zeta, int m zeta (l + x), int m zeta^2 of both bending shapes.
    """
    link, shapes = machine.links[index], ritz_shapes(machine)[index]
    grid = np.linspace(-link.length, 0.0, GRID)
    lever, lever_points, none = grid + link.length, x + link.length, np.zeros(GRID)
    rows, targets = [], []
    for power in range(3):
        rows.append(np.tile(lever**power, 2) / (mass @ lever_points**power) * EXACT)
        targets.append(EXACT)
    for axis in ("v", "w"):
        hinge, zeta = chains[axis].hinges[0], shapes[axis](x)
        swing = hinge.gain * (grid - hinge.position)
        for row, target in (
            (swing, mass @ zeta),
            (swing * lever, mass @ (zeta * lever_points)),
            (swing**2, mass @ zeta**2),
        ):
            rows.append(np.append(none, row) / target)
            targets.append(1.0)
    scale = PRIOR_WEIGHT / mass.sum()  # picks the smoothest of the many mass distributions that do
    system = np.vstack([*rows, scale * np.eye(2 * GRID)])
    found = nnls(system, np.append(targets, np.zeros(2 * GRID)))[0]
    return (grid, found[:GRID]), (grid, found[GRID:])
