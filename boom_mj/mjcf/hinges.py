"""Equivalent hinges: a link's static shape as hinge springs, one chain per elastic coordinate.

A shape zeta(x) is slope gathered along the link. Cut the link into n cells; the slope that cell j gathers becomes
the angle of one hinge, where its tip displacement is right, with a spring that stores the cell's strain energy:

    gain_j = int_j dzeta',    position_j = int_j x dzeta' / gain_j,    stiffness_j = int_j E I zeta''^2 dx / gain_j^2

With one cell this is the hinge at zeta(0) / zeta'(0) from the tip with stiffness K / zeta'(0)^2, and the shape is the
polynomial (18), so that it meets the reference model (`rayleigh` then tunes it by half a percent). With more cells the
shape is a static solution itself, so that the chain converges to the continuous beam. Torsion twists about the beam
axis, where its position is free.

Link 2 rests on its cylinder pin: what bends between root and pin is slope at the pin, gathered by the cell there.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise

import numpy as np
from scipy.integrate import cumulative_trapezoid

from boom_mj.machine import Elastic, ElasticLink, Shape, ritz_shapes, sections, shapes
from boom_mj.machine.shapes import static_curves
from boom_mj.machine.statics import StaticCurve

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


def hinge_chains(machine: Elastic, count: int) -> tuple[dict[str, HingeChain], ...]:
    """Per link the chains `torsion`, `v` and `w` of `count` hinges each."""
    return tuple(link_chains(machine, index, count, shapes.AXES) for index in range(len(machine.links)))


def link_chains(machine: Elastic, index: int, count: int, axes: Sequence[str]) -> dict[str, HingeChain]:
    """Chains of `count` hinges each of one link (0 is link 2)."""
    link = machine.links[index]
    return {axis: HingeChain(link.name, axis, _hinges(machine, index, axis, count)) for axis in axes}


def cell_edges(link: ElasticLink, count: int) -> Array:
    """Edges of the cells of a link, (count + 1,), m: their lengths follow the root of the bending stiffness.

    What a chain of hinges lacks in flexibility is the sum of length^3 / E I over its cells, least at this grading.
    """
    x = np.linspace(-link.length, 0.0, 401)
    share = cumulative_trapezoid(sections.bending_stiffness_v(link, x) ** -0.5, x, initial=0.0)
    return np.interp(np.linspace(0, share[-1], count + 1), share, x)


def _hinges(machine: Elastic, index: int, axis: str, count: int) -> tuple[Hinge, ...]:
    link = machine.links[index]
    curve: Shape | StaticCurve = (
        _static_curves(machine, index)[axis] if count > 1 else ritz_shapes(machine)[index][axis]
    )
    pin = link.support if axis == "v" and link.support is not None else -link.length
    stretch = np.hypot(1, link.offset / link.length) if machine.offset_profile.kind == "ramp" and count > 1 else 1.0

    def gathered(start: float, stop: float) -> Array:
        """Slope, its first moment and the strain energy (doubled) of a stretch, (3,)."""
        x, weight = _points(start, stop)
        bend = curve.strain(x)
        return np.array([weight @ bend, weight @ (bend * x), weight @ (shapes.STIFFNESS[axis](link, x) * bend**2)])

    edges = cell_edges(link, count)
    inboard = int(np.sum(edges[1:] <= pin))  # cells that lie between root and pin share what is gathered at the pin
    pin_slope = float(np.squeeze(curve.slope(np.array(pin)))) if pin > -link.length else 0.0
    at_pin = np.array([pin_slope, pin_slope * pin, gathered(-link.length, pin)[2]]) / (inboard + 1)
    found = []
    for number, (start, stop) in enumerate(pairwise(edges)):
        gain, moment, energy = gathered(max(start, pin), stop) if stop > pin else np.zeros(3)
        if number <= inboard:
            gain, moment, energy = np.array([gain, moment, energy]) + at_pin
        # a ramp's beam is longer than the link by `stretch`, and softer by as much
        found.append((moment / gain, energy / gain**2 / stretch, gain))
    strain_energy = sum(stiffness * gain**2 for _, stiffness, gain in found)
    relaxation = machine.damping.relaxation_time + _line_dissipation(machine, index, axis) / strain_energy
    return tuple(Hinge(float(x), float(k), float(gain), float(relaxation * k)) for x, k, gain in found)


@lru_cache(maxsize=64)
def _static_curves(machine: Elastic, index: int) -> Mapping[str, StaticCurve]:
    """Static solutions between weight and tip load: a tip force of half the last link's weight is added."""
    return static_curves(machine, index, machine.links[-1].mass * (machine.gravity or 9.81) / 2)


def _line_dissipation(machine: Elastic, index: int, axis: str) -> float:
    """Rayleigh coefficient of a Ritz coordinate from the dissipation per unit length of (24)."""
    link, damping = machine.links[index], machine.damping
    x, weight = sections.gauss_points(link)
    density = damping.torsion if axis == "torsion" else damping.bending
    if density == 0:
        return 0.0  # spares the shapes
    return density * float(weight @ ritz_shapes(machine)[index][axis](x) ** 2)


def _points(start: float, stop: float, order: int = 12) -> tuple[Array, Array]:
    node, weight = np.polynomial.legendre.leggauss(order)
    return start + (stop - start) * (node + 1) / 2, (stop - start) / 2 * weight
