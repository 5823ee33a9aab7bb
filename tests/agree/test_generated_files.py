"""What `generate` writes: keyframes that rest, sensors with names, a URDF that is the rigid chain of the MJCF model."""

import mujoco
import numpy as np
import pytest

from boom_mj.machine import Machine, load_machine
from boom_mj.mjcf import POSES_DEG, build, urdf_text
from boom_mj.simulation import make_plant

MACHINE = load_machine("boom36")


def opened(machine: Machine, hinges: int) -> tuple[mujoco.MjModel, mujoco.MjData]:
    model = mujoco.MjModel.from_xml_string(build(machine, hinges).to_xml())
    return model, mujoco.MjData(model)


@pytest.mark.parametrize("hinges", [1, 2, 5])
def test_keyframes_rest_under_weight(hinges: int) -> None:
    model, data = opened(MACHINE, hinges)
    plant = make_plant(MACHINE, hinges)
    assert [model.key(k).name for k in range(model.nkey)] == list(POSES_DEG)
    for k, pose in enumerate(POSES_DEG.values()):
        mujoco.mj_resetDataKeyframe(model, data, k)
        rest = plant.static_equilibrium(np.radians(pose))
        np.testing.assert_allclose(data.qpos, rest, rtol=5e-6, atol=1e-7)  # the text has six digits
        mujoco.mj_forward(model, data)
        before = data.site("tip").xpos.copy()
        for _ in range(round(5 / model.opt.timestep)):
            mujoco.mj_step(model, data)
        # the commands' last digit of 1e-6 rad moves a tip 20 m away by some hundredths of a millimetre
        np.testing.assert_allclose(data.site("tip").xpos, before, atol=2e-4)


def test_a_pose_beyond_the_limits_gets_no_keyframe() -> None:
    link = MACHINE.links[3].model_copy(update={"range_deg": (-160.0, 0.0)})
    model, _ = opened(MACHINE.model_copy(update={"link": (*MACHINE.link[:3], link)}), 1)
    assert [model.key(k).name for k in range(model.nkey)] == ["stretched", "bow"]


def test_sensors_have_names_and_say_what_they_are_named_after() -> None:
    model, data = opened(MACHINE, 1)
    mujoco.mj_resetDataKeyframe(model, data, model.key("bow").id)
    mujoco.mj_forward(model, data)
    assert all(model.sensor(k).name for k in range(model.nsensor))
    for k, angle in enumerate(POSES_DEG["bow"]):
        assert data.sensor(f"joint{k + 1}_position").data[0] == pytest.approx(np.radians(angle), rel=5e-6)
        assert data.sensor(f"drive{k + 1}_torque").data[0] == data.actuator(f"drive{k + 1}").force[0]
    assert (data.sensor("tip_position").data == data.site("tip").xpos).all()


def test_the_urdf_is_the_rigid_chain() -> None:
    """Of many hinges, all at zero: same masses, same mass matrix, same tip, at random poses."""
    spec = mujoco.MjSpec.from_string(urdf_text(MACHINE))
    spec.compiler.fusestatic = False
    rigid = spec.compile()
    plant = make_plant(MACHINE, 8)
    assert [rigid.joint(k).name for k in range(rigid.njnt)] == [f"joint{k + 1}" for k in range(5)]
    assert rigid.body_mass.sum() == pytest.approx(plant.model.body_mass.sum(), rel=1e-6)
    data, mass = mujoco.MjData(rigid), np.zeros((5, 5))
    for angles in np.random.default_rng(1).uniform(*rigid.jnt_range.T, size=(20, 5)):
        qpos = np.zeros(plant.model.nq)
        qpos[plant.joints] = data.qpos[:] = angles
        mujoco.mj_forward(rigid, data)
        mujoco.mj_fullM(rigid, data, mass)
        np.testing.assert_allclose(data.body("tip").xpos, plant.tip(qpos), atol=1e-6)
        full = plant.mass_matrix(qpos)[np.ix_(plant.joints, plant.joints)]
        # segments of a link have inertias of their own across the beam, below a thousandth of the link's
        np.testing.assert_allclose(mass, full, rtol=2e-3, atol=2e-3 * full.max())


def test_limits_of_the_urdf_are_the_machines() -> None:
    rigid = mujoco.MjSpec.from_string(urdf_text(MACHINE)).compile()
    np.testing.assert_allclose(rigid.jnt_range, [drive.range for drive in MACHINE.drives], rtol=1e-8)
    np.testing.assert_allclose(rigid.dof_damping.reshape(5, -1)[:, 0], [d.viscous_friction for d in MACHINE.drives])
