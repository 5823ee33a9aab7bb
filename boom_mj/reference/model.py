"""The paper's Lagrangian model (19)-(28): mass matrix, forces, static equilibria, modes, joint torques.

    D(q) qdd + tau_C(q, qd) + tau_p(q) + tau_r(qd) = tau + J_tip^T f_d                                   (25)

Integrals along the links are Gauss sums, exact for the polynomial shapes and linear densities. Derivatives of D and
tau_p are complex steps of the formulas themselves.
"""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from scipy.linalg import eigh

from boom_mj.errors import EquilibriumError
from boom_mj.machine import AXES, Machine, ritz_shapes, sections
from boom_mj.reference.kinematics import JOINTS, Section, chain_sections, coordinate_names

Array = np.ndarray
STEP = 1e-30  # of the complex-step derivatives


@dataclass(frozen=True)
class Simplifications:
    """What section 2.4 of the paper leaves out; the defaults are the paper's choice.

    Attributes:
        undeformed_mass: D = D(q_e = 0) instead of D(q).
        no_coriolis: tau_C = 0.
        linear_kinematics: elastic rotations linear in their angles (5); not a choice of section 2.4 but of section 2.1.
    """

    undeformed_mass: bool = True
    no_coriolis: bool = True
    linear_kinematics: bool = True


@dataclass(frozen=True)
class Modes:
    """Vibration about an equilibrium with the joints held, slowest first.

    Attributes:
        frequency: undamped, Hz, (12,).
        damping_ratio: (12,).
        shape: elastic coordinates of each mode in its column, (12, 12), largest entry 1.
    """

    frequency: Array
    damping_ratio: Array
    shape: Array


@dataclass(frozen=True)
class ReferenceModel:
    """The machine as the paper's equations of motion; every method is a pure function of the coordinates."""

    machine: Machine
    simplifications: Simplifications = field(default_factory=Simplifications)

    @cached_property
    def coordinates(self) -> tuple[str, ...]:
        """Names of the 17 coordinates."""
        return coordinate_names(self.machine)

    @cached_property
    def _masses(self) -> tuple[tuple[Array, ...], tuple[Array, ...], tuple[Array, ...]]:
        """Per link: places x, masses there (kg), rotary inertias there (kg m^2); line densities and point masses."""
        places, masses, inertias = [], [], []
        for link, points in zip(self.machine.links, self.machine.masses_on_link):
            x, weight = sections.gauss_points(link)
            places.append(np.append(x, [place for place, _ in points]))
            masses.append(np.append(weight * sections.line_mass(link, x), [mass for _, mass in points]))
            inertias.append(np.append(weight * sections.line_rotary_inertia(link, x), np.zeros(len(points))))
        return tuple(places), tuple(masses), tuple(inertias)

    def sections(self, q: Array, places: tuple[Array, ...]) -> tuple[Section, ...]:
        """Positions and Jacobians along the links; see `chain_sections`."""
        return chain_sections(self.machine, q, places, not self.simplifications.linear_kinematics)

    def mass_matrix(self, q: Array) -> Array:
        """D of (26) from (19), (20); (..., 17, 17), kg m^2, kg m, kg."""
        if self.simplifications.undeformed_mass:
            q = np.concatenate([q[..., :JOINTS], np.zeros_like(q[..., JOINTS:])], axis=-1)
        places, masses, inertias = self._masses
        total = np.zeros((*q.shape, q.shape[-1]), q.dtype)
        for section, mass, inertia in zip(self.sections(q, places), masses, inertias):
            weighted = np.moveaxis(section.jacobian * mass[:, None, None], -3, -2)  # (..., 17, p, 3)
            flat = np.moveaxis(section.jacobian, -3, -2)
            total = total + np.einsum("...apk,...bpk->...ab", weighted, flat)
            total = total + np.swapaxes(section.spin, -1, -2) @ (section.spin * inertia[:, None])
        return total

    def gravity_force(self, q: Array) -> Array:
        """Gradient of the potential energy of weight (21), (22); (..., 17)."""
        places, masses, _ = self._masses
        found = self.sections(q, places)
        return self.machine.gravity * sum(
            np.einsum("...pk,p->...k", s.jacobian[..., 2], m) for s, m in zip(found, masses)
        )

    @cached_property
    def stiffness(self) -> Array:
        """Diagonal of the elastic stiffness (23), (17,): zero for the joints, N m/rad and N/m."""
        elastic = [shapes[axis].stiffness for shapes in ritz_shapes(self.machine) for axis in AXES]
        return np.concatenate([np.zeros(JOINTS), elastic])

    @cached_property
    def damping(self) -> Array:
        """Diagonal of the dissipation (24) with the Kelvin-Voigt part of the machine file, (17,)."""
        damping = self.machine.damping
        line = []
        for link, shapes in zip(self.machine.links, ritz_shapes(self.machine)):
            x, weight = sections.gauss_points(link)
            for axis, density in zip(AXES, (damping.torsion, damping.bending, damping.bending)):
                line.append(density * float(weight @ shapes[axis](x) ** 2))
        joints = [drive.viscous_friction for drive in self.machine.drives]
        return np.concatenate([joints, line]) + damping.relaxation_time * self.stiffness

    def potential_force(self, q: Array) -> Array:
        """tau_p of (25): gradient of weight and strain energy, (..., 17)."""
        return self.gravity_force(q) + self.stiffness * q

    def coriolis_force(self, q: Array, velocity: Array) -> Array:
        """tau_C of (27), (17,): zero where the simplifications say so."""
        if self.simplifications.no_coriolis:
            return np.zeros_like(q)
        along = self.mass_matrix(q + 1j * STEP * velocity) @ velocity
        energies = self.mass_matrix(q + 1j * STEP * np.eye(q.size)) @ velocity @ velocity
        return np.imag(along - energies / 2) / STEP

    def tip(self, q: Array) -> tuple[Array, Array]:
        """World position (..., 3) of the boom's tip, m, and its Jacobian (..., 17, 3), that of the f_d of (28)."""
        ends = (*[np.zeros(0)] * (len(self.machine.links) - 1), np.zeros(1))
        last = self.sections(q, ends)[-1]
        return last.position[..., 0, :], last.jacobian[..., 0, :, :]

    def potential_stiffness(self, q: Array) -> Array:
        """Derivative of tau_p, (17, 17)."""
        return np.imag(self.potential_force(q + 1j * STEP * np.eye(q.size))).T / STEP

    def static_equilibrium(self, joints: Array, tip_force: Array | None = None) -> Array:
        """Coordinates (17,) at rest under weight and a force on the tip, with the joints held.

        Args:
            joints: q1..q5, rad.
            tip_force: world frame, (3,), N.

        Raises:
            EquilibriumError: Newton's method did not settle.
        """
        force = np.zeros(3) if tip_force is None else np.asarray(tip_force, float)
        q = np.concatenate([joints, np.zeros(self.stiffness.size - JOINTS)])

        def residual(q: Array) -> Array:
            return self.potential_force(q) - self.tip(q)[1] @ force

        for _ in range(30):
            slope = np.imag(residual(q + 1j * STEP * np.eye(q.size))).T / STEP
            step = np.linalg.solve(slope[JOINTS:, JOINTS:], residual(q)[JOINTS:])
            q[JOINTS:] -= step
            if np.max(np.abs(step)) < 1e-12:
                return q
        raise EquilibriumError(
            f"no static equilibrium at joints {np.degrees(joints).round(2)} deg under tip force {force} N: "
            f"the last Newton step was {np.max(np.abs(step)):.2g}"
        )

    def modes(self, q: Array) -> Modes:
        """Frequencies, damping ratios and shapes of small vibration about q with the joints held."""
        mass, stiffness = self.mass_matrix(q)[JOINTS:, JOINTS:], self.potential_stiffness(q)[JOINTS:, JOINTS:]
        square, shape = eigh((stiffness + stiffness.T) / 2, mass)
        frequency = np.sqrt(np.maximum(square, 0))
        modal_damping = np.einsum("ij,i,ij->j", shape, self.damping[JOINTS:], shape)
        return Modes(
            frequency / (2 * np.pi), modal_damping / (2 * frequency), shape / np.abs(shape).max(axis=0, keepdims=True)
        )

    def joint_torques(self, q: Array, velocity: Array, acceleration: Array, tip_force: Array) -> Array:
        """tau_1..tau_5 of (25), N m, that the drives exert."""
        force = self.mass_matrix(q) @ acceleration + self.coriolis_force(q, velocity) + self.potential_force(q)
        return (force + self.damping * velocity - self.tip(q)[1] @ tip_force)[:JOINTS]
