"""Rigid inertias for the bodies of a hinged link, physically consistent by construction."""

from dataclasses import dataclass

import numpy as np

from boom_mj.machine import Elastic, ritz_shapes, sections
from boom_mj.mjcf.hinges import HingeChain, seams
from boom_mj.mjcf.masses import mass_points, tuned_masses

Array = np.ndarray


@dataclass(frozen=True)
class RigidInertia:
    """Mass (kg), centre of mass (3,) in the link-tip frame (m), inertia tensor (3, 3) about it (kg m^2)."""

    mass: float
    center: Array
    tensor: Array


def segment_inertias(machine: Elastic, index: int, chains: dict[str, HingeChain]) -> tuple[RigidInertia, ...]:
    """Inertias of the bodies of one link, root outward: one more than its seams."""
    cuts = np.array([seam.place for seam in seams(machine.links[index], chains)])
    x, mass, inertia = mass_points(machine, index, cuts)
    inside = np.searchsorted(cuts, x)
    bodies = [(x[inside == k], mass[inside == k], float(inertia[inside == k].sum())) for k in range(len(cuts) + 1)]
    if len(cuts) == 1:
        spin = float(inertia @ ritz_shapes(machine)[index]["torsion"](x) ** 2)  # the twist's own entry
        bodies = [
            (place, share, part)
            for (place, share), part in zip(tuned_masses(machine, index, chains, x, mass), (inertia.sum() - spin, spin))
        ]
    return tuple(_rigid(machine, index, *body) for body in bodies)


def rigid_link(machine: Elastic, index: int) -> RigidInertia:
    """Inertia of one link that does not bend."""
    x, mass, inertia = mass_points(machine, index, np.zeros(0))
    return _rigid(machine, index, x, mass, float(inertia.sum()))


def beam_axis(machine: Elastic, index: int) -> Array:
    """Unit vector along the neutral axis in the link frame, (3,): a ramp's beam runs from root to tip."""
    link = machine.links[index]
    rise = link.offset if machine.offset_profile.kind == "ramp" else 0.0
    return np.array([link.length, 0.0, rise]) / np.hypot(link.length, rise)


def _rigid(machine: Elastic, index: int, x: Array, mass: Array, inertia: float) -> RigidInertia:
    """One body from masses on the neutral axis and its rotary inertia about it (kg m^2)."""
    link, axis = machine.links[index], beam_axis(machine, index)
    position = np.stack([x, np.zeros_like(x), sections.offset(link, machine.offset_profile.kind, x) - link.offset])
    total = float(mass.sum())
    center = position @ mass / total
    r = position - center[:, None]
    spread = (r * mass) @ r.T
    # a short stretch of box turns about its width and height too: half its rotary inertia each, if the line has less
    across = (np.eye(3) - np.outer(axis, axis)) * max(0.0, 0.505 * inertia - np.trace(spread))
    tensor = np.trace(spread) * np.eye(3) - spread + inertia * np.outer(axis, axis) + across
    return RigidInertia(total, center, tensor)
