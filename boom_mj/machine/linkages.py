"""Cylinder lengths over joint angles; the slope of a length is the moment arm of the cylinder's force.

Lengths are written without `abs`, so that a complex step gives the slope to machine precision.
"""

from collections.abc import Callable

import numpy as np

from boom_mj.errors import MachineFileError
from boom_mj.machine.model import Machine

Array = np.ndarray


def cylinder2_length(machine: Machine, q2: Array) -> Array:
    """Length of cylinder 2 over the angle of joint 2, m."""
    cylinder, x = machine.cylinder2, machine.cylinder2.rod.x + machine.links[0].length
    dx = np.cos(q2) * x - np.sin(q2) * cylinder.rod.y - cylinder.base[0]
    dy = np.sin(q2) * x + np.cos(q2) * cylinder.rod.y - cylinder.base[1]
    return np.sqrt(dx**2 + dy**2)


def cylinder3_length(machine: Machine, q3: Array) -> Array:
    """Length of cylinder 3 over the angle of joint 3, m; the rocker's end closes the four-bar on its branch."""
    cylinder = machine.cylinder3
    angle = q3 + np.radians(cylinder.lever.angle_deg)
    dx = cylinder.lever.length * np.cos(angle) - cylinder.rocker_pivot[0]
    dy = cylinder.lever.length * np.sin(angle) - cylinder.rocker_pivot[1]
    square = dx**2 + dy**2
    along = (square + cylinder.rocker_length**2 - cylinder.coupler_length**2) / (2 * square)
    across = cylinder.branch * np.sqrt(cylinder.rocker_length**2 / square - along**2)
    px = cylinder.rocker_pivot[0] + along * dx - across * dy - cylinder.base[0]
    py = cylinder.rocker_pivot[1] + along * dy + across * dx - cylinder.base[1]
    return np.sqrt(px**2 + py**2)


def moment_arm(length: Callable[[Machine, Array], Array], machine: Machine, angle: Array) -> Array:
    """Slope of a cylinder's length over its joint angle, m/rad."""
    return np.imag(length(machine, np.asarray(angle) + 1e-30j)) / 1e-30


def cylinder_forces(machine: Machine, angles: Array, torques: Array) -> Array:
    """Forces of cylinders 2 and 3 that make joint torques, by virtual work.

    Args:
        angles: joint angles q1..q5, (..., 5), rad.
        torques: joint torques, (..., 5), N m.

    Returns:
        (..., 2), N, positive in compression (the cylinder pushes); NaN where a linkage does not reach.

    Raises:
        MachineFileError: a cylinder has no moment arm.
    """
    arms = [
        moment_arm(cylinder2_length, machine, angles[..., 1]),
        moment_arm(cylinder3_length, machine, angles[..., 2]),
    ]
    for number, arm, angle in zip((2, 3), arms, (angles[..., 1], angles[..., 2])):
        if np.any(arm == 0):
            where = np.degrees(np.ravel(angle)[np.argmin(np.abs(np.ravel(arm)))])
            raise MachineFileError(
                f"{machine.name}: cylinder{number} has no moment arm at joint{number} = {where:.2f} deg"
            )
    return torques[..., 1:3] / np.stack(arms, axis=-1)


def cylinder_lengths(machine: Machine, angles: Array) -> Array:
    """Lengths of cylinders 2 and 3, (..., 2), m, over joint angles q1..q5, (..., 5), rad."""
    return np.stack([cylinder2_length(machine, angles[..., 1]), cylinder3_length(machine, angles[..., 2])], axis=-1)
