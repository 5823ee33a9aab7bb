"""One hinge per coordinate, in tune: stiffness that makes up for what the inertias cannot.

A hinge swings its outer body along a straight line where the shape bends, and no set of positive masses gives it quite
the kinetic energy of the shape. So the springs of all links are softened by the one factor per axis that gives the
stretched boom's static bending line, which is nearly its first mode, the Rayleigh quotient that it has with the shapes.
"""

from dataclasses import replace

import numpy as np

from boom_mj.machine import Elastic, ritz_shapes, sections
from boom_mj.machine.statics import outboard_load
from boom_mj.mjcf.hinges import HingeChain, seams
from boom_mj.mjcf.masses import mass_points, tuned_masses

Chains = tuple[dict[str, HingeChain], ...]


def in_tune(machine: Elastic, chains: Chains) -> Chains:
    """Chains of one hinge each with their bending springs softened."""
    factors = {"torsion": 1.0, **{axis: _energy_ratio(machine, chains, axis) for axis in ("v", "w")}}
    return tuple({axis: _scaled(chain, factors[axis]) for axis, chain in link.items()} for link in chains)


def _scaled(chain: HingeChain, factor: float) -> HingeChain:
    hinges = (replace(h, stiffness=factor * h.stiffness, damping=factor * h.damping) for h in chain.hinges)
    return replace(chain, hinges=tuple(hinges))


def _energy_ratio(machine: Elastic, chains: Chains, axis: str) -> float:
    """Kinetic energy of the bending line, hinged over shaped."""
    shift = turn = hinged = shaped = 0.0  # of the root of a link, m and rad, and energies so far
    for index, link in enumerate(machine.links):
        shape, hinge = ritz_shapes(machine)[index][axis], chains[index][axis].hinges[0]
        x, weight = sections.gauss_points(link)
        load = outboard_load(machine, index, gravity=1.0)
        work = weight @ (sections.line_mass(link, x) * shape(x)) + load.force + load.moment * shape.slope(0.0)
        bend = float(work / shape.stiffness)  # the link's Ritz coordinate under weight, by virtual work

        x, mass, _ = mass_points(machine, index, np.array([seam.place for seam in seams(link, chains[index])]))
        shaped += float(mass @ (shift + turn * (x + link.length) + bend * shape(x)) ** 2)
        for (place, part), moves in zip(tuned_masses(machine, index, chains[index], x, mass), (0.0, 1.0)):
            swing = moves * hinge.gain * (place - hinge.position)
            hinged += float(part @ (shift + turn * (place + link.length) + bend * swing) ** 2)
        shift, turn = shift + turn * link.length + bend, turn + bend * float(np.squeeze(shape.slope(0.0)))
    return float(hinged / shaped)
