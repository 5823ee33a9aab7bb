"""Equivalent hinges: a link's static shape as hinge springs, one chain per elastic coordinate.

A shape zeta(x) is slope gathered along the link. Cut the link into n cells; the slope that cell j gathers becomes
the angle of one hinge, where its tip displacement is right, with a spring that stores the cell's strain energy:

    gain_j = int_j dzeta',    position_j = int_j x dzeta' / gain_j,    stiffness_j = int_j E I zeta''^2 dx / gain_j^2

With one cell this is the hinge at zeta(0) / zeta'(0) from the tip with stiffness K / zeta'(0)^2, and the shape is the
polynomial (18), so that it meets the reference model. With more cells the shape is the static solution itself, so that
the chain converges to the continuous beam. Torsion twists about the beam axis, where its position is free.

Link 2 rests on its cylinder pin: what bends between root and pin is slope at the pin, gathered by the first cell.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from boom_mj.machine import Link, Machine, ritz_shapes, sections, shapes

Array = np.ndarray


@dataclass(frozen=True)
class Hinge:
    """One hinge spring.

    Attributes:
        position: x of the hinge, m.
        stiffness: N m/rad.
        gain: hinge angle per unit of the Ritz coordinate when the link has its shape, rad/m (torsion: rad/rad).
        damping: N m s/rad.
    """

    position: float
    stiffness: float
    gain: float
    damping: float


@dataclass(frozen=True)
class HingeChain:
    """The hinges of one elastic coordinate of one link, numbered from the root."""

    link: str
    axis: str
    hinges: tuple[Hinge, ...]

    @property
    def joint_names(self) -> tuple[str, ...]:
        return tuple(f"{self.link}_{self.axis}_{k + 1}" for k in range(len(self.hinges)))

    @property
    def readback(self) -> Array:
        """Row r with Ritz coordinate = r . hinge angles, (n,): the tip's deflection (m) or twist (rad)."""
        if self.axis == "torsion":
            return np.ones(len(self.hinges))
        return np.array([-hinge.position for hinge in self.hinges])


def hinge_chains(machine: Machine, count: int) -> tuple[dict[str, HingeChain], ...]:
    """Per link the chains `torsion`, `v` and `w` of `count` hinges each."""
    return tuple(
        {axis: HingeChain(link.name, axis, _hinges(machine, index, axis, count)) for axis in shapes.AXES}
        for index, link in enumerate(machine.links)
    )


def cell_edges(link: Link, count: int, supported: bool) -> Array:
    """Edges of equally long cells from where the link starts to gather slope to its tip, (count + 1,)."""
    start = link.support if supported and link.support is not None else -link.length
    return np.linspace(start, 0.0, count + 1)


def _hinges(machine: Machine, index: int, axis: str, count: int) -> tuple[Hinge, ...]:
    link, shape = machine.links[index], ritz_shapes(machine)[index][axis]
    strain, slope = (shape.strain, shape.slope) if count == 1 else (shape.static.strain, shape.static.slope)
    supported = axis == "v" and link.support is not None
    stretch = np.hypot(1, link.offset / link.length) if machine.offset_profile.kind == "ramp" and count > 1 else 1.0
    edges, found = cell_edges(link, count, supported), []
    for start, stop in pairwise(edges):
        x, weight = _points(start, stop)
        gain, moment = weight @ strain(x), weight @ (strain(x) * x)
        energy = weight @ (shapes.STIFFNESS[axis](link, x) * strain(x) ** 2)
        if supported and start == edges[0]:
            pin_slope = float(np.squeeze(slope(np.array(start))))
            gain, moment = gain + pin_slope, moment + pin_slope * start
            x, weight = _points(-link.length, start)
            energy += weight @ (shapes.STIFFNESS[axis](link, x) * strain(x) ** 2)
        # a ramp's beam is longer than the link by `stretch`, and softer by as much
        found.append((moment / gain, energy / gain**2 / stretch, gain))
    strain_energy = sum(stiffness * gain**2 for _, stiffness, gain in found)
    relaxation = machine.damping.relaxation_time + _line_dissipation(machine, index, axis) / strain_energy
    return tuple(Hinge(float(x), float(k), float(gain), float(relaxation * k)) for x, k, gain in found)


def _line_dissipation(machine: Machine, index: int, axis: str) -> float:
    """Rayleigh coefficient of a Ritz coordinate from the dissipation per unit length of (24)."""
    link, damping = machine.links[index], machine.damping
    x, weight = sections.gauss_points(link)
    density = damping.torsion if axis == "torsion" else damping.bending
    return density * float(weight @ ritz_shapes(machine)[index][axis](x) ** 2)


def _points(start: float, stop: float, order: int = 12) -> tuple[Array, Array]:
    node, weight = np.polynomial.legendre.leggauss(order)
    return start + (stop - start) * (node + 1) / 2, (stop - start) / 2 * weight
