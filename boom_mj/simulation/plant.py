"""A compiled boom: which entries of MuJoCo's state are joints, which are elastic hinges, and its rest and its modes."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import mujoco
import numpy as np
from scipy.linalg import eigh

from boom_mj.effects import Effect, ForceEffect, ModelEffect, Motion, effects_of
from boom_mj.errors import EffectError, EquilibriumError, numbers_of
from boom_mj.machine import Machine
from boom_mj.mjcf import BoomModel, build
from boom_mj.recording.names import JOINTS as JOINT_NAMES

Array = np.ndarray
JOINTS = 5
LONGEST_STEP = 0.3  # rad, of Newton's method
SHRINKING, NEAR = 0.2, 1e-3  # ratio and size (rad) of Newton steps below which the stiffness is not taken anew
FLOPPY = 1e-6  # N m/rad, what counts as no stiffness at all
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
    """A boom model, compiled, and the effects it has. `scratch` is overwritten by every method."""

    boom: BoomModel
    model: mujoco.MjModel
    effects: tuple[Effect, ...] = ()

    @cached_property
    def scratch(self) -> mujoco.MjData:
        """State to work on between simulations."""
        return mujoco.MjData(self.model)

    @property
    def machine(self) -> Machine:
        """The machine that it is a model of."""
        return self.boom.machine

    @cached_property
    def joints(self) -> Array:
        """Addresses of joint1..joint5 in qpos and qvel, (5,)."""
        return np.array([self.model.joint(f"joint{k + 1}").qposadr[0] for k in range(JOINTS)])

    @cached_property
    def elastic(self) -> Array:
        """Addresses of all but the driven joints in qpos and qvel: what gives, (nv - 5,)."""
        return np.setdiff1d(np.arange(self.model.nv), self.joints)

    @cached_property
    def ritz(self) -> Array:
        """Elastic Ritz coordinates = ritz @ qpos, (12, nq)."""
        return self.boom.ritz_matrix(self.model)

    def at(self, qpos: Array) -> mujoco.MjData:
        """State at some positions, (nq,), at rest, with what depends on them computed."""
        mujoco.mj_resetData(self.model, self.scratch)
        self.scratch.qpos[:] = qpos
        if self.model.nplastic:  # what can slip has slipped into rest
            mujoco.mj_fwdPosition(self.model, self.scratch)
            self.scratch.plastic[:] = relaxed(self.model, self.scratch.ten_length)
        mujoco.mj_fwdPosition(self.model, self.scratch)
        mujoco.mj_fwdVelocity(self.model, self.scratch)
        return self.scratch

    def mass_matrix(self, qpos: Array) -> Array:
        """(nv, nv)."""
        mass = np.zeros((self.model.nv, self.model.nv))
        mujoco.mj_fullM(self.model, self.at(qpos), mass)
        return mass

    def tip(self, qpos: Array) -> Array:
        """World position of the boom's tip, (3,), m."""
        return self.at(qpos).site("tip").xpos.copy()

    def markers(self, qpos: Array) -> Array:
        """World positions of the markers, (m, 3), m."""
        data, count = self.at(qpos), len(self.machine.links) * len(self.machine.sensors.markers_x)
        return np.array([data.site(f"marker{k + 1}").xpos for k in range(count)])

    def rest_force(self, qpos: Array, loads: Mapping[str, Array]) -> Array:
        """What is missing for rest at qpos: weight less springs less the forces on sites, per coordinate, (nv,)."""
        data, jacobian = self.at(qpos), np.zeros((3, self.model.nv))
        missing = data.qfrc_bias - data.qfrc_passive
        world = data.site("world").xmat.reshape(3, 3)
        for site, force in loads.items():
            mujoco.mj_jacSite(self.model, data, jacobian, None, self.model.site(site).id)
            missing -= jacobian.T @ (world @ force)
        return missing

    def stiffness(self, qpos: Array, loads: Mapping[str, Array] | None = None) -> Array:
        """Derivative of `rest_force` over what gives, symmetric, (nv - 5, nv - 5), N m/rad."""
        force = loads or {}
        columns = []
        for k in self.elastic:
            step = STEP * (np.arange(self.model.nv) == k)
            columns.append(self.rest_force(qpos + step, force) - self.rest_force(qpos - step, force))
        slope = np.array(columns).T[self.elastic] / (2 * STEP)
        return (slope + slope.T) / 2

    def static_equilibrium(
        self, joints: Array, tip_force: Array | None = None, loads: Mapping[str, Array] | None = None
    ) -> Array:
        """qpos (nq,) at rest under weight, a force on the tip and on other sites (world, N), joints at q1..q5 (rad).

        Raises:
            EquilibriumError: Newton's method did not settle.
        """
        force = {**(loads or {}), "tip": np.zeros(3) if tip_force is None else np.asarray(tip_force, float)}
        force["tip"] = force["tip"] + (loads or {}).get("tip", 0.0)
        qpos = np.zeros(self.model.nq)
        qpos[self.joints] = joints
        longest, slow = np.inf, True
        for _ in range(100):
            if slow:  # else the last stiffness still does
                with numbers_of(self.machine.name, EquilibriumError):
                    curvature, direction = np.linalg.eigh(self.stiffness(qpos, force))
            missing = self.rest_force(qpos, force)[self.elastic]
            # downhill along every axis, a pendulum that stands on its head included
            step = direction @ ((direction.T @ missing) / np.maximum(np.abs(curvature), FLOPPY))
            before, longest = longest, float(np.max(np.abs(step)))
            qpos[self.elastic] -= step * LONGEST_STEP / max(longest, LONGEST_STEP)
            if longest < 1e-11:
                return qpos
            slow = longest > min(SHRINKING * before, NEAR)
        raise EquilibriumError(
            f"no static equilibrium at joints {np.degrees(joints).round(2)} deg under tip force {force['tip']} N: "
            f"the last Newton step was {longest:.2g} rad"
        )

    def modes(self, qpos: Array) -> Vibration:
        """Frequencies, damping ratios and shapes of small vibration about qpos with the joints held."""
        square, damping, shape = self._modes(qpos)
        omega = np.sqrt(np.maximum(square, 0))
        return Vibration(omega / (2 * np.pi), damping / (2 * omega), shape)

    def _modes(self, qpos: Array) -> tuple[Array, Array, Array]:
        """Modal stiffness (1/s^2, negative where it falls), modal damping (1/s), (m,) each, and shapes (m, m)."""
        held = np.ix_(self.elastic, self.elastic)
        with numbers_of(self.machine.name, EquilibriumError):
            square, shape = eigh(self.stiffness(qpos), self.mass_matrix(qpos)[held])
        return square, np.einsum("ij,i,ij->j", shape, self.model.dof_damping[self.elastic], shape), shape

    def stable(self, qpos: Array) -> bool:
        """Whether the model's step keeps all modes about qpos bounded: (w h)^2 < 4 + 2 d h for each, d = 2 zeta w.

        That is the bound of semi-implicit Euler steps h with damping taken implicitly. A pendulum on its head falls,
        which is none of the step's doing.
        """
        square, damping, _ = self._modes(qpos)
        step = self.model.opt.timestep
        return bool(np.all(square * step**2 < 4 + 2 * damping * step))

    def static_torques(self, qpos: Array, tip_force: Array | None = None) -> Array:
        """Drive torques of joints 1-5 at rest, (5,), N m."""
        return self.rest_force(qpos, {} if tip_force is None else {"tip": tip_force})[self.joints]


def relaxed(model: mujoco.MjModel, tendon_length: Array) -> Array:
    """Rest ranges of the slipping tendons that leave them without force, (nplastic,)."""
    rest = np.zeros(model.nplastic)
    for tendon in np.flatnonzero(model.tendon_plasticadr >= 0):
        rest[model.tendon_plasticadr[tendon] :][:2] = tendon_length[tendon]
    return rest


def add_pushes(spec: mujoco.MjSpec, machine: Machine, effect: ForceEffect) -> None:
    """Actuators `push_SITE_x`.. for the sites that an effect pushes on."""
    at_rest = Motion(np.zeros(1), dict.fromkeys(JOINT_NAMES, np.zeros(1)), machine=machine)
    for site in effect.force(at_rest):
        for k, axis in enumerate("xyz"):
            if spec.actuator(f"push_{site}_{axis}") is None:
                kind = mujoco.mjtTrn.mjTRN_SITE
                push = spec.add_actuator(name=f"push_{site}_{axis}", target=site, refsite="world", trntype=kind)
                push.gear = np.eye(6)[k]


def make_plant(machine: Machine, hinges: int = 1, effects: Sequence[Effect] = ()) -> Plant:
    """Build and compile a machine's model with `hinges` hinges per elastic coordinate.

    Args:
        effects: beyond those that the machine file holds.
    """
    return with_effects(build(machine, hinges), (*effects_of(machine), *effects))


def with_effects(boom: BoomModel, effects: Sequence[Effect]) -> Plant:
    """A plant of a boom with effects; the boom itself stays as it is.

    Raises:
        EffectError: two effects would be the same part of the machine.
    """
    boom = replace(boom, spec=boom.spec.copy())
    for effect in effects:
        if isinstance(effect, ModelEffect):
            try:
                effect.edit(boom.spec, boom.machine)
            except ValueError as error:  # MuJoCo: a name is there already
                others = ", ".join(str(other) for other in effects if other is not effect)
                raise EffectError(f"{effect} cannot stand beside {others}: {error}") from error
        if isinstance(effect, ForceEffect):
            add_pushes(boom.spec, boom.machine, effect)
    return Plant(boom, boom.compile(), tuple(effects))
