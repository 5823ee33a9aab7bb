"""Time integration of the reference model: joints on a given path, the elastic coordinates free."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp

from boom_mj.errors import SimulationError
from boom_mj.reference.kinematics import JOINTS
from boom_mj.reference.model import ReferenceModel

Array = np.ndarray
JointMotion = Callable[[float], tuple[Array, Array, Array]]
"""Time to angle, velocity and acceleration of joints 1-5, rad."""


@dataclass(frozen=True)
class ReferenceMotion:
    """Samples of a solution of (25).

    Attributes:
        time: (n,), s.
        q: generalised coordinates, (n, 17).
        velocity: (n, 17).
        joint_torque: tau_1..tau_5, (n, 5), N m.
        tip: world position of the tip, (n, 3), m.
    """

    time: Array
    q: Array
    velocity: Array
    joint_torque: Array
    tip: Array


def integrate(
    model: ReferenceModel,
    joint_motion: JointMotion,
    tip_force: Callable[[float], Array],
    time: Array,
    relative_tolerance: float = 1e-7,
) -> ReferenceMotion:
    """Solve (25) from static equilibrium at time[0].

    Args:
        tip_force: time to the force on the tip, world frame, (3,), N; integrated piecewise smooth.
        time: sample times, (n,), s, increasing.

    Raises:
        SimulationError: the integrator gave up; the time is named.
    """
    elastic = slice(JOINTS, None)
    start = model.static_equilibrium(joint_motion(time[0])[0], tip_force(time[0]))

    def assemble(t: float, state: Array) -> tuple[Array, Array]:
        angle, speed, _ = joint_motion(t)
        half = state.size // 2
        return np.concatenate([angle, state[:half]]), np.concatenate([speed, state[half:]])

    def acceleration(t: float, q: Array, velocity: Array) -> Array:
        joints = joint_motion(t)[2]
        mass = model.mass_matrix(q)
        force = model.coriolis_force(q, velocity) + model.potential_force(q) + model.damping * velocity
        force = force - model.tip(q)[1] @ tip_force(t)
        return np.linalg.solve(mass[elastic, elastic], -force[elastic] - mass[elastic, :JOINTS] @ joints)

    def rate(t: float, state: Array) -> Array:
        q, velocity = assemble(t, state)
        return np.concatenate([velocity[elastic], acceleration(t, q, velocity)])

    rest = np.concatenate([start[elastic], np.zeros(start.size - JOINTS)])
    solution = solve_ivp(
        rate, (time[0], time[-1]), rest, "LSODA", time, rtol=relative_tolerance, atol=1e-9, max_step=0.02
    )
    if not solution.success:
        raise SimulationError(f"the reference model stopped at t = {solution.t[-1]:.3f} s: {solution.message}")

    samples = []
    for t, state in zip(solution.t, solution.y.T):
        q, velocity = assemble(t, state)
        full = np.concatenate([joint_motion(t)[2], acceleration(t, q, velocity)])
        samples.append((q, velocity, model.joint_torques(q, velocity, full, tip_force(t)), model.tip(q)[0]))
    q, velocity, torque, tip = (np.array(column) for column in zip(*samples))
    return ReferenceMotion(solution.t, q, velocity, torque, tip)
