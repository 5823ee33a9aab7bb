"""Where things are in the specification of a boom: bodies, hinges and stretches of its links, found by their names."""

from collections.abc import Iterator
from itertools import pairwise

import mujoco

from boom_mj.machine import Machine
from boom_mj.machine.shapes import STIFFNESS

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
    """Segments of a link with the x between which they lie, m: they meet midway between the bending hinges there."""
    bodies = link_bodies(spec, link)
    bending = {hinge.name: hinge for axis in ("v", "w") for hinge in link_hinges(spec, link, axis)}
    seams = [[hinge.pos[0] for hinge in body.joints if hinge.name in bending] for body in bodies[1:]]
    cuts = [-machine.links[link - 2].length, *(float(sum(seam) / len(seam)) for seam in seams), 0.0]
    return [(body, start, stop) for body, (start, stop) in zip(bodies, pairwise(cuts))]


def bent_by(spec: mujoco.MjSpec, machine: Machine, link: int, axis: str) -> list[tuple[mujoco.MjsJoint, float]]:
    """Hinges of v or w of a link, each with the length of link whose bend it gathers, m: E I / stiffness."""
    own = machine.links[link - 2]
    return [(h, float(STIFFNESS[axis](own, h.pos[0])) / h.stiffness[0]) for h in link_hinges(spec, link, axis)]


def add_series_hinge(spec: mujoco.MjSpec, joint: int, name: str) -> mujoco.MjsJoint:
    """A free hinge between a drive and the link that it turns, about the same axis."""
    drive = spec.joint(f"joint{joint}")
    return drive.parent.add_joint(name=name, pos=drive.pos, axis=drive.axis, armature=ARMATURE)
