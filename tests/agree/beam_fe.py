"""A boom as a fine Euler-Bernoulli / St Venant frame: the referee for models of fewer coordinates.

Small motions about the undeformed shape at given joint angles. It takes data from `boom_mj.machine` and no mechanics.
Each element is straight, Hermite cubics in bending, linear in torsion and stretch, with

    k = int EA u'u' + EI_v v''v'' + EI_w w''w'' + GJ a'a' ds,    m = int m (uu + vv + ww) + theta aa ds.

Model axes are those of link 2: all constraints then act on single coordinates, and every joint from 2 on turns about z.
A displacement is (nodes, 6): translation in m and rotation vector in rad; model axes inside, world axes at the door.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from scipy.sparse import coo_array, csr_array
from scipy.sparse.linalg import eigsh, spsolve

from boom_mj.machine import Link, Machine, cylinder_forces, sections

Array = np.ndarray
SectionLaw = Callable[[Array], Sequence[Array]]
"""Over s: line mass kg/m, rotary inertia kg m, EA N, EI_v and EI_w N m^2, GJ N m^2."""


@dataclass(frozen=True)
class Element:
    """One beam element between two nodes; matrices (12, 12) in its own axes, coordinates (u, v, w, rotations) twice."""

    nodes: tuple[int, int]
    turn: Array
    """(12, 12) own from nodal coordinates in model axes; holds the rigid lever from the first node, if any."""
    mass: Array
    stiffness: Array
    string: Array
    """Geometric stiffness of a unit tension, 1/m."""

    @property
    def dofs(self) -> Array:
        return np.concatenate([6 * node + np.arange(6) for node in self.nodes])

    def tension(self, displacement: Array) -> float:
        """Axial force, N, mean over the element."""
        own = self.turn @ displacement.ravel()[self.dofs]
        return float((self.stiffness @ own)[6])


def element(nodes: tuple[int, int], axes: Array, start: float, length: float, law: SectionLaw, lever: Array) -> Element:
    """The element over s in [start, start + length] with `axes` (3, 3) as columns in model axes."""
    point, weight = np.polynomial.legendre.leggauss(4)  # exact: quartic EI, linear mass
    xi, weight, h = (point + 1) / 2, weight * length / 2, length
    cubic = np.stack([1 - 3 * xi**2 + 2 * xi**3, h * xi * (1 - xi) ** 2, 3 * xi**2 - 2 * xi**3, h * xi**2 * (xi - 1)])
    slope = np.stack([6 * xi * (xi - 1) / h, (1 - xi) * (1 - 3 * xi), 6 * xi * (1 - xi) / h, xi * (3 * xi - 2)])
    bend = np.stack([(12 * xi - 6) / h**2, (6 * xi - 4) / h, (6 - 12 * xi) / h**2, (6 * xi - 2) / h])
    line, strain = np.stack([1 - xi, xi]), np.stack([-np.ones(4), np.ones(4)]) / h
    v, w, signs = (1, 5, 7, 11), (2, 4, 8, 10), np.array([[1.0], [-1.0], [1.0], [-1.0]])  # rotation about own y is -w'

    def square(density: Array, *shapes: tuple[tuple[int, ...], Array]) -> Array:
        total = np.zeros((12, 12))
        for places, shape in shapes:
            total[np.ix_(places, places)] += shape * (weight * density) @ shape.T
        return total

    m, theta, ea, ei_v, ei_w, gj = law(start + h * xi)
    mass = square(m, ((0, 6), line), (v, cubic), (w, signs * cubic)) + square(theta, ((3, 9), line))
    stiffness = square(ea, ((0, 6), strain)) + square(gj, ((3, 9), strain))
    stiffness += square(ei_v, (v, bend)) + square(ei_w, (w, signs * bend))
    turn = np.kron(np.eye(4), axes.T)
    turn[:3, 3:6] = axes.T @ -cross(lever)  # u at the lever's end = u + rotation x lever
    return Element(nodes, turn, mass, stiffness, square(np.ones(4), (v, slope), (w, signs * slope)))


def cross(vector: Array) -> Array:
    """(3, 3) matrix of `vector x`."""
    return np.cross(vector, np.eye(3)).T


def assemble(elements: Sequence[Element], name: str, count: int) -> csr_array:
    """Sum of the elements' matrices `name`, (6 count, 6 count) in model axes."""
    blocks = [e.turn.T @ getattr(e, name) @ e.turn for e in elements]
    rows = [np.broadcast_to(e.dofs[:, None], (12, 12)) for e in elements]
    row, column, value = np.array(rows), np.array([r.T for r in rows]), np.array(blocks)
    return coo_array((value.ravel(), (row.ravel(), column.ravel())), shape=(6 * count, 6 * count)).tocsr()


@dataclass(frozen=True)
class BeamModel:
    """The boom at fixed joint angles; build it with `beam_model`."""

    machine: Machine
    angles: Array
    """(5,), rad"""
    axes: Array
    """(3, 3) world from model axes"""
    nodes: Array
    """(nodes, 3), m, world; the tip is the last"""
    link_nodes: tuple[Array, ...]
    """Per link 2..5 its nodes, root outward; the first is the tip of the link before."""
    elements: tuple[Element, ...]
    support: int
    """The node at the cylinder pin of link 2"""
    free: Array
    """Coordinates that no constraint holds"""
    mass: csr_array
    stiffness: csr_array

    @property
    def _fall(self) -> Array:
        """Free fall of a node, (6,), m/s^2, model axes."""
        return np.concatenate([self.axes.T @ [0, 0, -self.machine.gravity], np.zeros(3)])

    def load(self, force_on_tip: Array = (0.0, 0.0, 0.0), gravity: bool = True) -> Array:
        """Nodal forces, (nodes, 6), model axes: the world force on the tip, N, and the weight."""
        fall = np.tile(self._fall, self.nodes.shape[0])
        load = (gravity * (self.mass @ fall)).reshape(-1, 6)
        load[-1, :3] += self.axes.T @ np.asarray(force_on_tip)
        return load

    def solve(self, load: Array) -> Array:
        """Displacement under nodal forces, both (nodes, 6), model axes."""
        displacement = np.zeros(load.size)
        stiffness = self.stiffness[self.free][:, self.free]
        displacement[self.free] = spsolve(stiffness.tocsc(), load.ravel()[self.free])
        return displacement.reshape(-1, 6)

    def to_world(self, displacement: Array) -> Array:
        return (displacement.reshape(-1, 2, 3) @ self.axes.T).reshape(displacement.shape)

    def static(self, force_on_tip: Array = (0.0, 0.0, 0.0), gravity: bool = True) -> Array:
        """Displacement (nodes, 6), world, under a world force on the tip, N, with or without the weight."""
        return self.to_world(self.solve(self.load(force_on_tip, gravity)))

    def tip_displacement(self, force_on_tip: Array = (0.0, 0.0, 0.0), gravity: bool = True) -> Array:
        """(3,), m, world."""
        return self.static(force_on_tip, gravity)[-1, :3]

    def modes(self, count: int) -> tuple[Array, Array]:
        """The lowest natural frequencies (count,), Hz, and shapes (count, nodes, 6), world, of unit modal mass."""
        stiffness, mass = (a[self.free][:, self.free].tocsc() for a in (self.stiffness, self.mass))
        square, vector = eigsh(stiffness, count, mass, sigma=0.0, v0=np.ones(self.free.size))
        order = np.argsort(square)
        shapes = np.zeros((count, self.nodes.shape[0] * 6))
        shapes[:, self.free] = vector.T[order]
        return np.sqrt(square[order]) / (2 * np.pi), self.to_world(shapes.reshape(count, -1, 6))

    def in_plane_share(self, shape: Array) -> float:
        """Part of the kinetic energy of a shape (nodes, 6), world, that is motion in the boom's plane, 0 to 1."""
        model = (shape.reshape(-1, 2, 3) @ self.axes).reshape(shape.shape)
        plane = (model * [1, 1, 0, 0, 0, 1]).ravel()
        return float(plane @ self.mass @ plane / (model.ravel() @ self.mass @ model.ravel()))

    def joint_torques(self, force_on_tip: Array = (0.0, 0.0, 0.0), gravity: bool = True) -> Array:
        """Torques (5,), N m, that the joints exert on the boom in static equilibrium, positive with their angles.

        On the undeformed shape; with `geometric` on the deformed one, where joint 1 suffers from what that leaves out.
        """
        load = self.load(force_on_tip, gravity)
        displacement = self.solve(load)
        reaction = self.to_world((self.stiffness @ displacement.ravel() - load.ravel()).reshape(-1, 6))
        torques = np.zeros(5)
        torques[0] = (np.cross(self.nodes, reaction[:, :3]) + reaction[:, 3:]).sum(axis=0)[2]
        second = self.machine.links[0]
        torques[1] = reaction[self.support, :3] @ self.axes[:, 1] * (second.length + second.support)
        for joint, nodes in enumerate(self.link_nodes[1:], start=2):
            first = next(e for e in self.elements if e.nodes[0] == nodes[0])
            own = first.stiffness @ first.turn @ displacement.ravel()[first.dofs]
            own -= gravity * (first.mass @ first.turn @ np.tile(self._fall, 2))
            torques[joint] = (first.turn.T @ own)[5]
        return torques

    def cylinder_forces(self, force_on_tip: Array = (0.0, 0.0, 0.0), gravity: bool = True) -> Array:
        """Forces of cylinders 2 and 3, (2,), N, positive in compression."""
        return cylinder_forces(self.machine, self.angles, self.joint_torques(force_on_tip, gravity))


def beam_model(machine: Machine, angles: Array, elements: int = 40, geometric: bool = False) -> BeamModel:
    """The boom at joint angles (5,), rad, with about `elements` elements a link.

    A link with the offset profile "ramp" is a straight beam from (0, 0, 0) to (l, 0, offset): line densities of the
    machine file hold per unit x, stiffnesses per section. With "step" the offset is a rigid lever at the joint.

    Args:
        geometric: add the geometric stiffness of the axial forces under gravity. Complete to second order for motion in
            the boom's plane; out of it the couplings with bending moments (lateral buckling) are left out.
    """
    angles = np.asarray(angles, dtype=float)
    sine, cosine = np.sin(angles[0]), np.cos(angles[0])
    slewed = np.array([[cosine, 0, sine], [sine, 0, -cosine], [0, 1, 0]])  # columns x1, y1, z1
    parts, nodes, link_nodes, masses = [], [np.zeros(3)], [], []
    for link, q, points in zip(machine.links, [0.0, *np.cumsum(angles[2:])], machine.masses_on_link):
        frame = _turn_about_z(q)
        lever, run = np.zeros(3), np.array([link.length, 0.0, link.offset])
        if machine.offset_profile.kind == "step":
            lever, run = frame[:, 2] * link.offset, run * [1, 1, 0]
        stretch = np.linalg.norm(run) / link.length
        own_x = frame @ run / np.linalg.norm(run)
        own = np.stack([own_x, frame[:, 1], np.cross(own_x, frame[:, 1])], axis=1)
        places = _places(link, [x for x, _ in points], elements)
        number = len(nodes) - 1 + np.arange(places.size)
        along = (places + link.length) * stretch
        nodes += list(nodes[-1] + lever + along[1:, None] * own_x)
        for a, (s0, s1) in zip(number.tolist(), pairwise(along)):
            parts.append(element((a, a + 1), own, s0, s1 - s0, _law(link, stretch), lever * (a == number[0])))
        masses += [(number[np.argmin(abs(places - x))], m) for x, m in points]
        link_nodes.append(number)
        if link.support is not None:
            support = int(number[np.argmin(abs(places - link.support))])
    count = len(nodes)
    fixed = [0, 1, 2, 3, 4, 6 * support + 1]  # the root of link 2 turns about z only
    extra = np.zeros((count, 6))
    for node, m in masses:
        extra[node, :3] += m
    diagonal = np.arange(6 * count)
    mass = assemble(parts, "mass", count) + coo_array((extra.ravel(), (diagonal, diagonal))).tocsr()
    axes = slewed @ _turn_about_z(angles[1])
    world = np.array(nodes) @ axes.T + [0, 0, machine.slewing.pivot_height]
    free = np.setdiff1d(diagonal, fixed)
    stiffness = assemble(parts, "stiffness", count)
    model = BeamModel(machine, angles, axes, world, tuple(link_nodes), tuple(parts), support, free, mass, stiffness)
    if not geometric:
        return model
    rest = model.solve(model.load())
    tight = tuple(replace(e, stiffness=e.stiffness + e.tension(rest) * e.string) for e in parts)
    return replace(model, elements=tight, stiffness=assemble(tight, "stiffness", count))


def _turn_about_z(angle: float) -> Array:
    sine, cosine = np.sin(angle), np.cos(angle)
    return np.array([[cosine, -sine, 0], [sine, cosine, 0], [0, 0, 1]])


def _places(link: Link, points: Sequence[float], elements: int) -> Array:
    """Node places x on a link, root outward: evenly between the places that must be nodes."""
    corners = sorted({-link.length, 0.0, *points, *([] if link.support is None else [link.support])})
    counts = [max(1, round(elements * (b - a) / link.length)) for a, b in pairwise(corners)]
    pieces = [np.linspace(a, b, n + 1)[1:] for (a, b), n in zip(pairwise(corners), counts)]
    return np.concatenate([corners[:1], *pieces])


def _law(link: Link, stretch: float) -> SectionLaw:
    """Densities and stiffnesses over s = (x + l) * stretch."""

    def law(s: Array) -> Sequence[Array]:
        x = s / stretch - link.length
        height, width, wall = (sections.linear(pair, link, x) for pair in (link.height, link.width, link.wall))
        return (
            sections.line_mass(link, x) / stretch,
            sections.line_rotary_inertia(link, x) / stretch,
            link.youngs_modulus_y * 2 * wall * (height + width - 2 * wall),
            sections.bending_stiffness_v(link, x),
            sections.bending_stiffness_w(link, x),
            sections.torsional_stiffness(link, x),
        )

    return law
