"""Where things are in the specification of a boom: bodies, hinges and stretches of its links, found by their names."""

from collections.abc import Iterator
from itertools import pairwise

import mujoco

from boom_mj.machine import Machine

ARMATURE = 1.0  # kg m^2, far below any link, so that a mass matrix without the drive's own stays regular


def link_bodies(spec: mujoco.MjSpec, link: int) -> list[mujoco.MjsBody]:
    """Rigid segments of a link, root outward."""
    found, number = [spec.body(f"link{link}")], 2
    while (body := spec.body(f"link{link}_{number}")) is not None:
        found.append(body)
        number += 1
    return found


def link_hinges(spec: mujoco.MjSpec, link: int, axis: str) -> list[mujoco.MjsJoint]:
    """Equivalent hinges of one coordinate (v, w or torsion) of a link, root outward."""
    found: list[mujoco.MjsJoint] = []
    while (joint := spec.joint(f"link{link}_{axis}_{len(found) + 1}")) is not None:
        found.append(joint)
    return found


def elastic_hinges(spec: mujoco.MjSpec, machine: Machine) -> Iterator[mujoco.MjsJoint]:
    """Every equivalent hinge."""
    for number in range(2, 2 + len(machine.links)):
        for axis in ("v", "w", "torsion"):
            yield from link_hinges(spec, number, axis)


def stretches(spec: mujoco.MjSpec, machine: Machine, link: int) -> list[tuple[mujoco.MjsBody, float, float]]:
    """Segments of a link with the x between which they lie, m."""
    bodies, hinges = link_bodies(spec, link), link_hinges(spec, link, "v")
    cuts = [-machine.links[link - 2].length, *(float(hinge.pos[0]) for hinge in hinges), 0.0]
    return [(body, start, stop) for body, (start, stop) in zip(bodies, pairwise(cuts))]


def add_series_hinge(spec: mujoco.MjSpec, joint: int, name: str) -> mujoco.MjsJoint:
    """A free hinge between a drive and the link that it turns, about the same axis."""
    drive = spec.joint(f"joint{joint}")
    return drive.parent.add_joint(name=name, pos=drive.pos, axis=drive.axis, armature=ARMATURE)
