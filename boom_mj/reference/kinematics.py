"""Kinematics of the elastic chain (1)-(12): where material points are, and how they move with each coordinate.

Generalised coordinates q = [q1..q5, qa2, qv2, qw2, ..., qa5, qv5, qw5]. Everything takes leading batch axes and
complex q, so that a complex step differentiates it to machine precision.
"""

from dataclasses import dataclass

import numpy as np

from boom_mj.machine import AXES, Machine, ritz_shapes, sections

Array = np.ndarray
JOINTS = 5
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


def chain_sections(machine: Machine, q: Array, places: tuple[Array, ...]) -> tuple[Section, ...]:
    """Cross-sections of every link at the given x.

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
    for index, (link, shapes) in enumerate(zip(machine.links, ritz_shapes(machine))):
        columns = [TORSION + 3 * index, V + 3 * index, W + 3 * index]
        qa, qv, qw = (q[..., k] for k in columns)
        turn, d_turn = _turn(q[..., 1 + index])
        d_rotation = d_rotation @ turn[..., None, :, :]
        d_rotation[..., 1 + index, :, :] += rotation @ d_turn
        rotation = rotation @ turn

        x = places[index]
        za, zv, zw = (shapes[axis](x) for axis in AXES)
        arm = np.zeros((*batch, x.size, 3), kind)  # lam(x), v, d + w in the turned frame (2), (3)
        arm[..., 0] = link.length + x
        arm[..., 1] = qv[..., None] * zv
        arm[..., 2] = qw[..., None] * zw + sections.offset(link, machine.offset_profile.kind, x)
        jacobian = d_origin[..., None, :, :] + np.einsum("...kij,...pj->...pki", d_rotation, arm)
        jacobian[..., columns[1], :] += rotation[..., None, :, 1] * zv[:, None]
        jacobian[..., columns[2], :] += rotation[..., None, :, 2] * zw[:, None]
        position = origin[..., None, :] + np.einsum("...ij,...pj->...pi", rotation, arm)
        spin = np.einsum("...ki,...i->...k", _angular(d_rotation, rotation), rotation[..., :, 0])[..., None, :]
        spin = np.repeat(spin, x.size, axis=-2)
        spin[..., columns[0]] += za
        found.append(Section(position, jacobian, spin))

        # the tip of this link carries the next one: (5)-(8) at x = 0
        lever = np.stack([np.full_like(qv, link.length), qv, qw + link.offset], axis=-1)
        d_origin = d_origin + np.einsum("...kij,...j->...ki", d_rotation, lever)
        d_origin[..., columns[1], :] += rotation[..., :, 1]
        d_origin[..., columns[2], :] += rotation[..., :, 2]
        origin = origin + np.einsum("...ij,...j->...i", rotation, lever)
        slope_v, slope_w = shapes["v"].slope(0.0), shapes["w"].slope(0.0)
        bend = _small_rotation(qa, -qw * slope_w, qv * slope_v)
        d_rotation = d_rotation @ bend[..., None, :, :]
        one, zero = np.ones_like(qa), np.zeros_like(qa)
        for column, d_bend in zip(
            columns, ((one, zero, zero), (zero, zero, one * slope_v), (zero, -one * slope_w, zero))
        ):
            d_rotation[..., column, :, :] += rotation @ (_small_rotation(*d_bend) - np.eye(3))
        rotation = rotation @ bend
    return tuple(found)


def _turn(angle: Array) -> tuple[Array, Array]:
    """Rotation about z and its derivative, (..., 3, 3)."""
    turn, d_turn = np.zeros((*angle.shape, 3, 3), angle.dtype), np.zeros((*angle.shape, 3, 3), angle.dtype)
    c, s = np.cos(angle), np.sin(angle)
    turn[..., 0, 0], turn[..., 0, 1], turn[..., 1, 0], turn[..., 1, 1], turn[..., 2, 2] = c, -s, s, c, 1
    d_turn[..., 0, 0], d_turn[..., 0, 1], d_turn[..., 1, 0], d_turn[..., 1, 1] = -s, -c, c, -s
    return turn, d_turn


def _small_rotation(alpha: Array, beta: Array, gamma: Array) -> Array:
    """R~ (5), linear in its angles, (..., 3, 3)."""
    one = np.ones_like(alpha)
    rows = [[one, -gamma, beta], [gamma, one, -alpha], [-beta, alpha, one]]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def _angular(d_rotation: Array, rotation: Array) -> Array:
    """d omega / d qdot (10), (11): entries (3,2), (1,3), (2,1) of dR R^T, (..., 17, 3)."""
    skew = d_rotation @ np.swapaxes(rotation, -1, -2)[..., None, :, :]
    return np.stack([skew[..., 2, 1], skew[..., 0, 2], skew[..., 1, 0]], axis=-1)
