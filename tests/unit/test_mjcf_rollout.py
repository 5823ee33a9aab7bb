"""What a simulated stretch of an MJCF machine says of the forces that moved it."""

import mujoco
import numpy as np
import pytest

from boom_mj.systems.mjcf.rollout import Inputs, Run, simulate

MASS, GEAR = 2.0, 3.0
MODEL = f"""
<mujoco>
  <option timestep="0.01" integrator="INTEGRATOR"><flag gravity="disable"/></option>
  <worldbody>
    <body><joint name="slide" type="slide" axis="1 0 0"/><geom size="0.1" mass="{MASS}"/></body>
  </worldbody>
  <actuator><position name="servo" joint="slide" kp="40" kv="6" gear="{GEAR}"/></actuator>
</mujoco>
"""


@pytest.mark.parametrize("integrator", ["Euler", "implicit", "implicitfast"])
def test_a_servo_exerts_what_moves_the_mass(integrator: str) -> None:
    """F = m dv/dt in every step: an implicit one takes the servo's damping at the speed with which it ends."""
    model = mujoco.MjSpec.from_string(MODEL.replace("INTEGRATOR", integrator)).compile()
    time = 0.01 * np.arange(200)
    command = np.where(time > 0.2, 0.5, 0.0)
    (run,) = simulate(model, [Inputs(time, {}, {"servo": command}, {}, {"slide": (0.0, 0.0)})])
    assert isinstance(run, Run)
    acceleration = np.diff(run.position["slide"], 2) / 0.01**2
    assert np.abs(acceleration).max() > 5
    assert run.force["servo"][1:-1] == pytest.approx(MASS * acceleration, abs=1e-6)
