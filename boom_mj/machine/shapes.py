"""Ritz shape functions (12), (18): polynomials fitted to the static deflections, normalised to 1 at the tip.

So an elastic coordinate is what the tip of its link does: qa its twist in rad, qv and qw its deflection in m. The
horizontal shapes bend under the inertia of a boom that is accelerated sideways, so that vertical and horizontal
vibration meet alike; the paper leaves their load open.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from numpy.polynomial import Polynomial

from boom_mj.machine import sections, statics
from boom_mj.machine.model import Elastic, ElasticLink
from boom_mj.machine.statics import StaticCurve

Array = np.ndarray
AXES = ("torsion", "v", "w")
"""Elastic coordinates of a link in their order in q (12)."""
STIFFNESS = {
    "torsion": sections.torsional_stiffness,
    "v": sections.bending_stiffness_v,
    "w": sections.bending_stiffness_w,
}


@dataclass(frozen=True)
class Shape:
    """One shape function zeta(x) of a link.

    Attributes:
        polynomial: zeta over x in [-length, 0]; zeta(0) = 1.
        coefficients: a and b of (18), after the normalisation.
        fit_error: largest difference from the static solution, as a fraction of the tip value.
        stiffness: strain energy is stiffness q^2 / 2 (23); N m/rad for torsion, N/m for bending.
    """

    axis: str
    polynomial: Polynomial
    coefficients: tuple[float, float]
    fit_error: float
    stiffness: float

    def __call__(self, x: Array | float) -> Array:
        return self.polynomial(x)

    def slope(self, x: Array | float) -> Array:
        """zeta'(x), 1/m."""
        return self.polynomial.deriv()(x)

    def strain(self, x: Array) -> Array:
        """zeta' of torsion, zeta'' of bending: what the strain energy (23) squares."""
        return self.polynomial.deriv(1 if self.axis == "torsion" else 2)(x)


@lru_cache(maxsize=64)
def ritz_shapes(machine: Elastic) -> tuple[Mapping[str, Shape], ...]:
    """Shapes `torsion`, `v` and `w` of every link, root outward."""
    found = []
    for index, link in enumerate(machine.links):
        s = Polynomial([link.length, 1])  # distance from the root
        v_basis = (s**2, s**3) if link.support is None else tuple(Polynomial([-link.support, 1]) * s**k for k in (1, 2))
        bases = {"torsion": (s, s**2), "v": v_basis, "w": (s**2, s**3)}
        found.append({axis: _fit(link, axis, c, bases[axis]) for axis, c in static_curves(machine, index).items()})
    return tuple(found)


def static_curves(machine: Elastic, index: int) -> Mapping[str, StaticCurve]:
    """Static solutions `torsion`, `v` and `w` of link `index` (0 is link 2), each 1 at its tip."""
    link, gravity = machine.links[index], machine.gravity or 9.81  # a weightless boom has the shape of a heavy one
    load = statics.outboard_load(machine, index, gravity)
    curves = {
        "torsion": statics.torsion(link),
        "v": statics.bending(link, sections.bending_stiffness_v, load, gravity, link.support),
        "w": statics.bending(link, sections.bending_stiffness_w, load, gravity, None),
    }
    return {axis: curve.over_tip() for axis, curve in curves.items()}


def _fit(link: ElasticLink, axis: str, static: StaticCurve, basis: tuple[Polynomial, ...]) -> Shape:
    """Least squares (18) to a static solution, then normalised to 1 at the tip."""
    x = np.linspace(-link.length, 0, 201)
    curve = static.value(x)
    coefficients = np.linalg.lstsq(np.stack([p(x) for p in basis], axis=1), curve)[0]
    coefficients /= sum(c * p(0.0) for c, p in zip(coefficients, basis))
    polynomial = sum((c * p for c, p in zip(coefficients, basis)), Polynomial([0.0]))
    points, weights = sections.gauss_points(link)
    shape = Shape(
        axis=axis,
        polynomial=polynomial,
        coefficients=(float(coefficients[0]), float(coefficients[1])),
        fit_error=float(np.max(np.abs(polynomial(x) - curve))),
        stiffness=0.0,
    )
    return replace(
        shape, stiffness=float(weights @ (STIFFNESS[axis](link, points) * shape.strain(points) ** 2))
    )  # (23)
