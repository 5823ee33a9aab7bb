"""A compiled boom: which entries of MuJoCo's state are joints, which are elastic hinges, and its rest and its modes."""

from dataclasses import dataclass
from functools import cached_property

import mujoco
import numpy as np
from scipy.linalg import eigh

from boom_mj.errors import EquilibriumError
from boom_mj.machine import Machine
from boom_mj.mjcf import BoomModel, build

Array = np.ndarray
JOINTS = 5
STEP = 1e-6  # rad, central differences of MuJoCo's forces: their error is its square, times a curvature of order 1


@dataclass(frozen=True)
class Vibration:
    """Modes about an equilibrium with the joints held, slowest first.

    Attributes:
        frequency: undamped, Hz, (m,).
        damping_ratio: (m,).
        shape: hinge angles of each mode in its column, (m, m), unit modal mass.
    """

    frequency: Array
    damping_ratio: Array
    shape: Array


@dataclass(frozen=True)
class Plant:
    """A boom model, compiled. `scratch` is overwritten by every method and carries nothing between calls."""

    boom: BoomModel
    model: mujoco.MjModel

    @cached_property
    def scratch(self) -> mujoco.MjData:
        return mujoco.MjData(self.model)

    @property
    def machine(self) -> Machine:
        return self.boom.machine

    @cached_property
    def joints(self) -> Array:
        """Addresses of joint1..joint5 in qpos and qvel, (5,)."""
        return np.array([self.model.joint(f"joint{k + 1}").qposadr[0] for k in range(JOINTS)])

    @cached_property
    def elastic(self) -> Array:
        """Addresses of the elastic hinges in qpos and qvel, (nv - 5,)."""
        return np.setdiff1d(np.arange(self.model.nv), self.joints)

    @cached_property
    def ritz(self) -> Array:
        """Elastic Ritz coordinates = ritz @ qpos, (12, nq)."""
        return self.boom.ritz_matrix(self.model)

    def _at(self, qpos: Array) -> mujoco.MjData:
        mujoco.mj_resetData(self.model, self.scratch)
        self.scratch.qpos[:] = qpos
        mujoco.mj_forward(self.model, self.scratch)
        return self.scratch

    def mass_matrix(self, qpos: Array) -> Array:
        """(nv, nv)."""
        mass = np.zeros((self.model.nv, self.model.nv))
        mujoco.mj_fullM(self.model, self._at(qpos), mass)
        return mass

    def tip(self, qpos: Array) -> Array:
        """World position of the boom's tip, (3,), m."""
        return self._at(qpos).site("tip").xpos.copy()

    def rest_force(self, qpos: Array, tip_force: Array) -> Array:
        """What is missing for rest at qpos: weight less springs less the tip force, per coordinate, (nv,)."""
        data, jacobian = self._at(qpos), np.zeros((3, self.model.nv))
        mujoco.mj_jacSite(self.model, data, jacobian, None, self.model.site("tip").id)
        return data.qfrc_bias - data.qfrc_passive - jacobian.T @ tip_force

    def stiffness(self, qpos: Array, tip_force: Array | None = None) -> Array:
        """Derivative of `rest_force` over the elastic hinges, symmetric, (nv - 5, nv - 5), N m/rad."""
        force = np.zeros(3) if tip_force is None else tip_force
        columns = []
        for k in self.elastic:
            step = STEP * (np.arange(self.model.nv) == k)
            columns.append(self.rest_force(qpos + step, force) - self.rest_force(qpos - step, force))
        slope = np.array(columns).T[self.elastic] / (2 * STEP)
        return (slope + slope.T) / 2

    def static_equilibrium(self, joints: Array, tip_force: Array | None = None) -> Array:
        """qpos (nq,) at rest under weight and a force on the tip (world, N), joints held at q1..q5 (rad).

        Raises:
            EquilibriumError: Newton's method did not settle.
        """
        force = np.zeros(3) if tip_force is None else np.asarray(tip_force, float)
        qpos = np.zeros(self.model.nq)
        qpos[self.joints] = joints
        for _ in range(20):
            step = np.linalg.solve(self.stiffness(qpos, force), self.rest_force(qpos, force)[self.elastic])
            qpos[self.elastic] -= step
            if np.max(np.abs(step)) < 1e-11:
                return qpos
        raise EquilibriumError(
            f"no static equilibrium at joints {np.degrees(joints).round(2)} deg under tip force {force} N: "
            f"the last Newton step was {np.max(np.abs(step)):.2g} rad"
        )

    def modes(self, qpos: Array) -> Vibration:
        """Frequencies, damping ratios and shapes of small vibration about qpos with the joints held."""
        held = np.ix_(self.elastic, self.elastic)
        square, shape = eigh(self.stiffness(qpos), self.mass_matrix(qpos)[held])
        omega = np.sqrt(np.maximum(square, 0))
        damping = np.einsum("ij,i,ij->j", shape, self.model.dof_damping[self.elastic], shape)
        return Vibration(omega / (2 * np.pi), damping / (2 * omega), shape)

    def static_torques(self, qpos: Array, tip_force: Array | None = None) -> Array:
        """Drive torques of joints 1-5 at rest, (5,), N m."""
        return self.rest_force(qpos, np.zeros(3) if tip_force is None else tip_force)[self.joints]


def make_plant(machine: Machine, hinges: int = 1) -> Plant:
    """Build and compile a machine's model with `hinges` hinges per elastic coordinate."""
    boom = build(machine, hinges)
    return Plant(boom, boom.compile())
