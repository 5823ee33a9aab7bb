"""Kinematics of the elastic chain (1)-(12): where material points are, and how they move with each coordinate.

Generalised coordinates q = [q1..q5, qa2, qv2, qw2, ..., qa5, qv5, qw5]. Everything takes leading batch axes and
complex q, so that a complex step differentiates it to machine precision.
"""

from dataclasses import dataclass

import numpy as np

from boom_mj.machine import AXES, Machine, Shape, ritz_shapes, sections

Array = np.ndarray
JOINTS = 5
"""Joint angles come first among the coordinates."""
TORSION, V, W = (JOINTS + k for k in range(3))  # columns of link 2; link i adds 3 (i - 2)


def coordinate_names(machine: Machine) -> tuple[str, ...]:
    """q1..q5, then link2_torsion, link2_v, link2_w, ..., link5_w."""
    joints = tuple(f"q{k + 1}" for k in range(JOINTS))
    return joints + tuple(f"{link.name}_{axis}" for link in machine.links for axis in AXES)


@dataclass(frozen=True)
class Section:
    """A cross-section of one link and all that moves with it.

    Attributes:
        position: world, (..., 3), m.
        jacobian: d position / dq, (..., 17, 3).
        spin: d (rotation about the link's own axis) / dq, (..., 17), rad; the omega_x that (19) needs.
    """

    position: Array
    jacobian: Array
    spin: Array


def chain_sections(
    machine: Machine, q: Array, places: tuple[Array, ...], finite_rotations: bool = False
) -> tuple[Section, ...]:
    """Cross-sections of every link at the given x.

    The paper's kinematics are linear in the elastic angles (5). With `finite_rotations` the elastic rotation is a
    rotation, and a bent link draws its points in by half the integral of its squared slope.

    Args:
        q: generalised coordinates, (..., 17).
        places: per link an array of x in [-length, 0], m.

    Returns:
        Per link one `Section` whose arrays carry the places as an axis before the last ones:
        position (..., p, 3), jacobian (..., p, 17, 3), spin (..., p, 17).
    """
    batch, count, kind = q.shape[:-1], q.shape[-1], q.dtype
    rotation, d_rotation = np.zeros((*batch, 3, 3), kind), np.zeros((*batch, count, 3, 3), kind)
    c, s = np.cos(q[..., 0]), np.sin(q[..., 0])
    rotation[..., 0, 0], rotation[..., 0, 2], rotation[..., 1, 0], rotation[..., 1, 2] = c, s, s, -c  # (2), kappa = 90
    rotation[..., 2, 1] = 1
    d_rotation[..., 0, 0, 0], d_rotation[..., 0, 0, 2] = -s, c
    d_rotation[..., 0, 1, 0], d_rotation[..., 0, 1, 2] = c, s
    origin = np.zeros((*batch, 3), kind)
    origin[..., 2] = machine.slewing.pivot_height
    d_origin = np.zeros((*batch, count, 3), kind)

    found = []
    for index, shapes in enumerate(ritz_shapes(machine)):
        columns = [TORSION + 3 * index, V + 3 * index, W + 3 * index]
        turn, d_turn = _turn_about(q[..., 1 + index], 2)
        d_rotation = d_rotation @ turn[..., None, :, :]
        d_rotation[..., 1 + index, :, :] += rotation @ d_turn
        rotation = rotation @ turn

        arm, d_arm = _arms(machine, index, q[..., columns], places[index], finite_rotations)
        jacobian = d_origin[..., None, :, :] + np.einsum("...kij,...pj->...pki", d_rotation, arm)
        jacobian[..., columns, :] += np.einsum("...ij,...pkj->...pki", rotation, d_arm)
        position = origin[..., None, :] + np.einsum("...ij,...pj->...pi", rotation, arm)
        spin = np.einsum("...ki,...i->...k", _angular(d_rotation, rotation), rotation[..., :, 0])[..., None, :]
        spin = np.repeat(spin, places[index].size, axis=-2)
        spin[..., columns[0]] += shapes["torsion"](places[index])
        found.append(Section(position, jacobian, spin))

        # the tip of this link carries the next one: (5)-(8) at x = 0
        arm, d_arm = _arms(machine, index, q[..., columns], np.zeros(1), finite_rotations)
        d_origin = d_origin + np.einsum("...kij,...j->...ki", d_rotation, arm[..., 0, :])
        d_origin[..., columns, :] += np.einsum("...ij,...kj->...ki", rotation, d_arm[..., 0, :, :])
        origin = origin + np.einsum("...ij,...j->...i", rotation, arm[..., 0, :])
        slopes = np.array([1.0, -shapes["w"].slope(0.0), shapes["v"].slope(0.0)])  # of alpha, beta, gamma (4)
        angles = q[..., [columns[0], columns[2], columns[1]]] * slopes
        bend, d_bend = (_rotation if finite_rotations else _small_rotation)(angles)
        d_rotation = d_rotation @ bend[..., None, :, :]
        for k, column in enumerate((columns[0], columns[2], columns[1])):
            d_rotation[..., column, :, :] += rotation @ d_bend[..., k, :, :] * slopes[k]
        rotation = rotation @ bend
    return tuple(found)


def _turn_about(angle: Array, axis: int) -> tuple[Array, Array]:
    """Rotation about one axis of the frame and its derivative, (..., 3, 3)."""
    turn, d_turn = np.zeros((*angle.shape, 3, 3), angle.dtype), np.zeros((*angle.shape, 3, 3), angle.dtype)
    first, second = (axis + 1) % 3, (axis + 2) % 3
    c, s = np.cos(angle), np.sin(angle)
    turn[..., axis, axis] = 1
    for matrix, along, across in ((turn, c, s), (d_turn, -s, c)):
        matrix[..., first, first], matrix[..., second, second] = along, along
        matrix[..., first, second], matrix[..., second, first] = -across, across
    return turn, d_turn


def _arms(machine: Machine, index: int, elastic: Array, x: Array, finite: bool) -> tuple[Array, Array]:
    """(lam(x), v, d + w) of (2), (3) in the turned link frame, (..., p, 3); slope over qa, qv, qw, (..., p, 3, 3)."""
    link, shapes = machine.links[index], ritz_shapes(machine)[index]
    qv, qw = elastic[..., 1, None], elastic[..., 2, None]
    arm = np.zeros((*qv.shape[:-1], x.size, 3), elastic.dtype)
    d_arm = np.zeros((*qv.shape[:-1], x.size, 3, 3), elastic.dtype)
    arm[..., 0] = link.length + x
    arm[..., 1] = qv * shapes["v"](x)
    arm[..., 2] = qw * shapes["w"](x) + sections.offset(link, machine.offset_profile.kind, x)
    d_arm[..., 1, 1], d_arm[..., 2, 2] = shapes["v"](x), shapes["w"](x)
    if finite:
        drawn_v, drawn_w = _drawn_in(shapes["v"], link.length, x), _drawn_in(shapes["w"], link.length, x)
        arm[..., 0] -= (qv**2 * drawn_v + qw**2 * drawn_w) / 2
        d_arm[..., 1, 0], d_arm[..., 2, 0] = -qv * drawn_v, -qw * drawn_w
    return arm, d_arm


def _drawn_in(shape: Shape, length: float, x: Array) -> Array:
    """Integral of zeta'^2 from the root to x, 1/m."""
    return (shape.polynomial.deriv() ** 2).integ(lbnd=-length)(x)


def _small_rotation(angles: Array) -> tuple[Array, Array]:
    """R~ of (5), linear in (alpha, beta, gamma), (..., 3, 3), and its derivatives, (..., 3, 3, 3)."""
    generators = np.array(
        [
            [[0, 0, 0], [0, 0, -1], [0, 1, 0]],
            [[0, 0, 1], [0, 0, 0], [-1, 0, 0]],
            [[0, -1, 0], [1, 0, 0], [0, 0, 0]],
        ],
        angles.dtype,
    )
    slopes = np.broadcast_to(generators, (*angles.shape[:-1], 3, 3, 3))
    return np.eye(3) + np.einsum("...k,kij->...ij", angles, generators), slopes


def _rotation(angles: Array) -> tuple[Array, Array]:
    """Rz(gamma) Ry(beta) Rx(alpha), (..., 3, 3), and its derivatives, (..., 3, 3, 3)."""
    (rz, dz), (ry, dy), (rx, dx) = (_turn_about(angles[..., k], k) for k in (2, 1, 0))
    return rz @ ry @ rx, np.stack([rz @ ry @ dx, rz @ dy @ rx, dz @ ry @ rx], axis=-3)


def _angular(d_rotation: Array, rotation: Array) -> Array:
    """d omega / d qdot (10), (11), (..., 17, 3).

    The paper reads three entries of dR R^T. With the linear R~ of (5) that matrix is not quite skew and its entries are
    no vector; its skew part is taken, which is the same for a rotation and turns with the frame for R~.
    """
    product = d_rotation @ np.swapaxes(rotation, -1, -2)[..., None, :, :]
    skew = (product - np.swapaxes(product, -1, -2)) / 2
    return np.stack([skew[..., 2, 1], skew[..., 0, 2], skew[..., 1, 0]], axis=-1)
