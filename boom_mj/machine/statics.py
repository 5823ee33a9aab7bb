"""Static torsion and bending of single links: the boundary value problems (13)-(17), solved numerically.

The loads at the tip of a link are those of everything outboard of it on the stretched horizontal boom.
"""

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.integrate import solve_bvp

from boom_mj.machine import sections
from boom_mj.machine.model import Elastic, ElasticLink

Array = np.ndarray
Density = Callable[[ElasticLink, Array], Array]


@dataclass(frozen=True)
class TipLoad:
    """What hangs on the tip of a link: `force` (N) pulls it down, `moment` (N m) bends it down; Fy0, -Mz0 of (16)."""

    force: float
    moment: float


def outboard_load(machine: Elastic, index: int, gravity: float) -> TipLoad:
    """Weight of everything outboard of link `index` (0 is link 2)."""
    force = moment = reach = 0.0
    for link, points in zip(machine.links[index + 1 :], machine.masses_on_link[index + 1 :]):
        masses = ((link.center_of_gravity, link.mass), *points)
        reach += link.length
        force += gravity * sum(mass for _, mass in masses)
        moment += gravity * sum(mass * (reach + x) for x, mass in masses)
    force += gravity * sum(mass for x, mass in machine.masses_on_link[index] if x == 0)
    return TipLoad(force, moment)


@dataclass(frozen=True)
class StaticCurve:
    """A static solution along a link: its value, its slope and its strain (alpha' or v''), each over x."""

    value: Callable[[Array], Array]
    slope: Callable[[Array], Array]
    strain: Callable[[Array], Array]

    def over_tip(self) -> "StaticCurve":
        """The same curve with value 1 at the tip."""
        tip = float(self.value(np.zeros(1))[0])
        return StaticCurve(
            *(lambda x, f=f: f(np.asarray(x)) / tip for f in (self.value, self.slope, self.strain)),
        )


def torsion(link: ElasticLink) -> StaticCurve:
    """Twist of a link under a unit moment at its tip (13), (14), rad."""
    tip = float(sections.torsional_stiffness(link, 0.0))

    def rate(s: Array, y: Array) -> Array:
        twist = y[1] * tip / sections.torsional_stiffness(link, (s - 1) * link.length)
        return np.stack([twist, np.zeros_like(s)])

    solution = _solve(rate, lambda root, end: np.array([root[0], end[1] - 1]), 2)

    def strain(x: Array) -> Array:
        return 1 / sections.torsional_stiffness(link, x)

    return StaticCurve(lambda x: link.length / tip * solution(1 + x / link.length)[0], strain, strain)


def bending(link: ElasticLink, stiffness: Density, tip: TipLoad, gravity: float, support: float | None) -> StaticCurve:
    """Static deflection (15) of a link under its own weight and a tip load, m.

    Args:
        stiffness: bending stiffness along the link, N m^2.
        gravity: acceleration that acts on the line mass, m/s^2.
        support: None clamps the root (16); else the root is pinned and v(support) = 0, both v' and v'' continuous (17).
    """
    length, tip_stiffness = link.length, stiffness(link, np.array(0.0))
    spans = np.array([-length, 0.0] if support is None else [-length, support, 0.0])
    moment = tip.moment + tip.force * length + gravity * link.mass * length
    flexibility = moment * length / tip_stiffness

    def rate(s: Array, y: Array) -> Array:
        """State per span: v/length, v', moment, shear, scaled; s in [0, 1] runs over every span at once."""
        rows = []
        for k, (start, stop) in enumerate(pairwise(spans)):
            x, ratio = start + s * (stop - start), (stop - start) / length
            load = -gravity * sections.line_mass(link, x) * length**2 / moment
            bend = y[4 * k + 2] * tip_stiffness / stiffness(link, x)
            rows += [ratio * flexibility * y[4 * k + 1], ratio * bend, ratio * y[4 * k + 3], ratio * load]
        return np.stack(rows)

    def boundary(root: Array, end: Array) -> Array:
        free = [end[-2] + tip.moment / moment, end[-1] - tip.force * length / moment]
        if support is None:
            return np.array([root[0], root[1], *free])
        return np.array([root[0], root[2], end[0], root[4], end[1] - root[5], end[2] - root[6], *free])

    solution = _solve(rate, boundary, 4 * (len(spans) - 1))

    def state(row: int, x: Array) -> Array:
        x = np.atleast_1d(x)
        span = np.clip(np.searchsorted(spans, x, side="right") - 1, 0, len(spans) - 2)
        s = (x - spans[span]) / (spans[span + 1] - spans[span])
        return solution(s)[4 * span + row, np.arange(x.size)]

    return StaticCurve(
        lambda x: length * state(0, x),
        lambda x: flexibility * state(1, x),
        lambda x: moment * state(2, x) / stiffness(link, np.atleast_1d(x)),
    )


def _solve(rate: Callable, boundary: Callable, states: int) -> Callable:
    mesh = np.linspace(0, 1, 41)
    result = solve_bvp(rate, boundary, mesh, np.zeros((states, mesh.size)), tol=1e-8, max_nodes=20000)
    if not result.success:
        raise ArithmeticError(f"static boundary value problem: {result.message}")
    return result.sol
