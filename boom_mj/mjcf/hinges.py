"""Equivalent hinges: the bending and twisting of a link as hinge springs, one chain per elastic coordinate.

A hinge is a point at which the flexibility of a link is sampled. What a load M does to the motion along another, m, is

    int M m dC,    dC = dx / E I (G J for torsion),

and n hinges at the nodes of the n-point Gauss rule of dC, each as flexible as its weight, do the same as long as M m is
a polynomial of degree 2 n - 1: forces at joints from n = 2 on, weight from n = 3 on, however the section tapers,

    sum_i c_i p(x_i) = int p dC    for all p of degree 2 n - 1,    stiffness_i = 1 / c_i.

In a uniform link these are Gauss-Legendre nodes, and c_i = weight_i / E I. Frequencies follow with the fourth order,
since masses ride on a polygon, for modes with fewer than about n / 4 waves on a link.

Link 2 rests on its cylinder pin, and between root and pin its moment grows linearly from nothing. So the pin is a node,
the first of a Radau rule of the span beyond, and what bends before it, int ((x + l) / (pin + l))^2 dC, is slope there.

One hinge is the paper's model: it has the shape zeta (18) in one point, zeta(0) / zeta'(0) from the tip with stiffness
K / zeta'(0)^2, and `rayleigh` tunes it by half a percent. A twist is about the beam axis, where its position is free.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from boom_mj.machine import Elastic, ElasticLink, ritz_shapes, sections, shapes
from boom_mj.mjcf.quadrature import gauss_rule, points, radau_rule

Array = np.ndarray
SAMPLES = 64  # of dC per span: the rules of 32 hinges are exact with smooth sections
TURNS = ("torsion", "v", "w")
"""Order of the hinges at every other seam, reversed between.

Finite turns do not commute: one order throughout leaves half a product of two angles at every seam, which in a boom
bent by its weight is a twist and changes the first lateral frequency with 1 / n, by 0.2 % at n = 4; so it cancels.
"""


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


@dataclass(frozen=True)
class Seam:
    """Where two bodies of a link meet.

    Attributes:
        place: x, m.
        hinges: number (from 0) of the hinge of each axis that turns there, in their order from the root.
    """

    place: float
    hinges: Mapping[str, int]


def seams(link: ElasticLink, chains: Mapping[str, HingeChain]) -> tuple[Seam, ...]:
    """Seams of a link, root outward.

    Hinges of v and w lie within a hundredth of a link of each other and share a seam midway. Not so on a link that
    rests on a pin, where each has its own: mass between them would follow both, and the limit would be off by 0.04 %.
    """
    v, w = ([hinge.position for hinge in chains[axis].hinges] for axis in ("v", "w"))
    if len(v) == 1:
        return (Seam((v[0] + w[0]) / 2, dict.fromkeys(("v", "w", "torsion"), 0)),)
    turns = [TURNS[:: (-1) ** k] for k in range(len(v))]
    if link.support is None:
        return tuple(Seam((v[k] + w[k]) / 2, dict.fromkeys(turn, k)) for k, turn in enumerate(turns))
    found = [Seam(x, {"v": k}) for k, x in enumerate(v)]
    found += [Seam(x, {axis: k for axis in turn if axis != "v"}) for k, (x, turn) in enumerate(zip(w, turns))]
    return tuple(sorted(found, key=lambda seam: seam.place))


def hinge_chains(machine: Elastic, count: int) -> tuple[dict[str, HingeChain], ...]:
    """Per link the chains `torsion`, `v` and `w` of `count` hinges each."""
    return tuple(link_chains(machine, index, count, shapes.AXES) for index in range(len(machine.links)))


def link_chains(machine: Elastic, index: int, count: int, axes: Sequence[str]) -> dict[str, HingeChain]:
    """Chains of `count` hinges each of one link (0 is link 2)."""
    name, found = machine.links[index].name, {}
    for axis in axes:
        position, stiffness, gain = (_sampled if count > 1 else _shaped)(machine, index, axis, count)
        relaxation = machine.damping.relaxation_time + _line_dissipation(machine, index, axis) / (stiffness @ gain**2)
        rows = np.stack([position, stiffness, gain, relaxation * stiffness], axis=1).tolist()
        found[axis] = HingeChain(name, axis, tuple(Hinge(*row) for row in rows))
    return found


def _shaped(machine: Elastic, index: int, axis: str, count: int) -> tuple[Array, Array, Array]:
    """Position, stiffness and gain of the paper's hinge, (1,) each."""
    shape = ritz_shapes(machine)[index][axis]
    gain = 1.0 if axis == "torsion" else float(shape.slope(0.0))
    twisted = shape.polynomial.integ()
    position = twisted(-machine.links[index].length) - twisted(0.0) if axis == "torsion" else -1 / gain
    return np.array([position]), np.array([shape.stiffness / gain**2]), np.array([gain])


def _sampled(machine: Elastic, index: int, axis: str, count: int) -> tuple[Array, Array, Array]:
    """Positions, stiffnesses and gains of hinges at the nodes of the flexibility's rule, (count,) each."""
    link, shape = machine.links[index], ritz_shapes(machine)[index][axis]
    stiff, root = shapes.STIFFNESS[axis], -link.length
    # a ramp's beam is longer than the link, and softer by as much
    stretch = np.hypot(1, link.offset / link.length) if machine.offset_profile.kind == "ramp" else 1.0

    def flexibility(start: float, stop: float) -> tuple[Array, Array]:
        x, weight = points(start, stop, SAMPLES)
        return x, stretch * weight / stiff(link, x)

    if axis == "v" and link.support is not None:
        position, flexible = radau_rule(link.support, *flexibility(link.support, 0.0), count)
        x, inboard = flexibility(root, link.support)
        flexible[0] += inboard @ ((x - root) / (link.support - root)) ** 2
    else:
        position, flexible = gauss_rule(*flexibility(root, 0.0), count)
    bend = flexible * stiff(link, position) * shape.strain(position)
    reach = np.ones(count) if axis == "torsion" else -position
    return position, 1 / flexible, bend / (reach @ bend)


def _line_dissipation(machine: Elastic, index: int, axis: str) -> float:
    """Rayleigh coefficient of a Ritz coordinate from the dissipation per unit length of (24)."""
    link, damping = machine.links[index], machine.damping
    x, weight = sections.gauss_points(link)
    density = damping.torsion if axis == "torsion" else damping.bending
    if density == 0:
        return 0.0  # spares the shapes
    return density * float(weight @ ritz_shapes(machine)[index][axis](x) ** 2)
