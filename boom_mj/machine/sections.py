"""Box sections and line densities along a link, x in [-length, 0], all vectorised over x."""

import numpy as np

from boom_mj.machine.model import ElasticLink

Array = np.ndarray


def linear(pair: tuple[float, float], link: ElasticLink, x: Array | float) -> Array:
    """A (root, tip) pair at x (29, 30)."""
    return pair[1] + (pair[1] - pair[0]) * np.asarray(x) / link.length


def line_mass(link: ElasticLink, x: Array | float) -> Array:
    """m(x), kg/m."""
    return linear(link.line_mass, link, x)


def line_rotary_inertia(link: ElasticLink, x: Array | float) -> Array:
    """theta_xx(x), kg m (29)."""
    return linear(link.rotary_inertia, link, x)


def second_moment_y(link: ElasticLink, x: Array | float) -> Array:
    """j_y(x), the integral of y^2 over the box section, m^4: vertical bending (15)."""
    height, width, wall = (linear(pair, link, x) for pair in (link.height, link.width, link.wall))
    return (width * height**3 - (width - 2 * wall) * (height - 2 * wall) ** 3) / 12


def second_moment_z(link: ElasticLink, x: Array | float) -> Array:
    """j_z(x), the integral of z^2 over the box section, m^4: horizontal bending."""
    height, width, wall = (linear(pair, link, x) for pair in (link.height, link.width, link.wall))
    return (height * width**3 - (height - 2 * wall) * (width - 2 * wall) ** 3) / 12


def torsion_constant(link: ElasticLink, x: Array | float) -> Array:
    """j_t(x), m^4: thin-walled box (31) at every x.

    The paper takes it linear between the ends (30); that overestimates a tapered box, whose j_t grows with the third
    power of its size, by 3 to 4 % - enough to shift the lateral frequency of a bent boom by 1 %.
    """
    by, bz, t = (linear(pair, link, x) for pair in (link.height, link.width, link.wall))
    return 2 * t**2 * (by - t) ** 2 * (bz - t) ** 2 / (by * t + bz * t - 2 * t**2)


def bending_stiffness_v(link: ElasticLink, x: Array | float) -> Array:
    """E_y j_y(x), N m^2."""
    return link.youngs_modulus_y * second_moment_y(link, x)


def bending_stiffness_w(link: ElasticLink, x: Array | float) -> Array:
    """E_z j_z(x), N m^2."""
    return link.youngs_modulus_z * second_moment_z(link, x)


def torsional_stiffness(link: ElasticLink, x: Array | float) -> Array:
    """G j_t(x), N m^2."""
    return link.shear_modulus * torsion_constant(link, x)


def offset(link: ElasticLink, profile: str, x: Array | float) -> Array:
    """d_i(x) of (2), m: lateral place of the neutral axis, a ramp from root to tip or a step at the joint."""
    x = np.asarray(x)
    return link.offset * (1 + x / link.length) if profile == "ramp" else np.full_like(x, link.offset, dtype=float)


def gauss_points(link: ElasticLink, order: int = 8) -> tuple[Array, Array]:
    """Gauss-Legendre points and weights over the link, (order,) each: exact to polynomial degree 2 order - 1."""
    node, weight = np.polynomial.legendre.leggauss(order)
    return link.length * (node - 1) / 2, link.length / 2 * weight
