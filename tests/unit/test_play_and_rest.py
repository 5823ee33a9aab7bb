"""Two effects against what pencil and paper say of them: friction behind play, a spring that relaxes."""

import mujoco
import numpy as np
import pytest

from boom_mj.effects import Effect, Site, effect_library

FRICTION, STIFFNESS, GAP = 7.0, 5e3, 1.5e-3  # N, N/m, m
SLIDE = f"""<mujoco><option timestep="0.0005" integrator="implicitfast" gravity="0 0 0"/><worldbody><body name="cart">
<joint name="slide" type="slide" axis="1 0 0" frictionloss="{FRICTION}" armature="1e6"/>
<geom type="box" size="1 1 1" mass="1"/></body></worldbody></mujoco>"""
SPRING = """<mujoco><option timestep="0.0005" integrator="implicitfast" gravity="0 0 0"/><worldbody><body name="cart">
<joint name="slide" type="slide" axis="1 0 0" stiffness="100"/>
<geom type="box" size="1 1 1" mass="1"/></body></worldbody>
<actuator><motor name="push" joint="slide"/></actuator></mujoco>"""
TAGS = frozenset({"mjcf", "rubbing", "sprung"})
SITE = Site((("joint", "slide"),), TAGS, unit="m", value=FRICTION, span=0.1, friction=FRICTION)


def effect(name: str, **values: float) -> Effect:
    return effect_library()[name](SITE, **values)


def edited(xml: str, *effects: Effect) -> mujoco.MjSpec:
    spec = mujoco.MjSpec.from_string(xml)
    for one in effects:
        one.edit(spec, None)  # type: ignore[attr-defined]
    return spec


def forces(spec: mujoco.MjSpec, path: np.ndarray) -> np.ndarray:
    """Passive force of a joint that moves along a path, (n,): its armature is too large for the force to move it."""
    model = spec.compile()
    data, found = mujoco.MjData(model), np.empty(len(path))
    speed = np.gradient(path, model.opt.timestep)
    for k in range(len(path)):
        data.qpos[0], data.qvel[0] = path[k], speed[k]
        mujoco.mj_step(model, data)
        found[k] = data.qfrc_passive[0]
    return found


def test_a_reversal_unloads_the_spring_and_crosses_the_gap() -> None:
    path = np.concatenate([np.linspace(0, 0.02, 4000), np.linspace(0.02, 0.0, 4000)])
    found = forces(edited(SLIDE, effect("friction_behind_play", half_gap=GAP, stiffness=STIFFNESS)), path)
    assert found[3999] == pytest.approx(-FRICTION, rel=0.01)
    back = 0.02 - path[4000:]
    free = back[np.abs(found[4000:]) < 0.01 * FRICTION]
    step = 0.02 / 4000
    assert free[0] == pytest.approx(FRICTION / STIFFNESS, abs=4 * step)
    assert np.ptp(free) == pytest.approx(2 * GAP, abs=0.03 * FRICTION / STIFFNESS + 4 * step)
    assert found[-1] == pytest.approx(FRICTION, rel=0.01)


def test_friction_that_comes_on_top_lies_behind_the_play_in_either_order() -> None:
    play, more = (
        effect("friction_behind_play", half_gap=GAP, stiffness=STIFFNESS),
        effect("coulomb_friction", force=3.0),
    )
    path = np.linspace(0, 0.02, 4000)
    for order in ((play, more), (more, play)):
        assert forces(edited(SLIDE, *order), path)[-1] == pytest.approx(-FRICTION - 3.0, rel=0.01)


def test_rest_is_softer_than_motion_by_the_share_that_relaxes() -> None:
    spec = edited(SPRING, effect("relaxing_stiffness", share=0.3, time=0.5))
    model = spec.compile()
    data = mujoco.MjData(model)
    data.ctrl[0] = 1.0
    for _ in range(60_000):  # 30 s
        mujoco.mj_step(model, data)
    assert data.joint("slide").qpos[0] == pytest.approx(1.0 / (100 * 0.7), rel=0.01)
    slow = edited(SPRING, effect("relaxing_stiffness", share=0.3, time=50.0)).compile()
    data = mujoco.MjData(slow)
    data.joint("slide").qpos[0] = 0.01
    path = []
    for _ in range(4000):
        mujoco.mj_step(slow, data)
        path.append(float(data.joint("slide").qpos[0]))
    crossings = np.flatnonzero(np.diff(np.sign(path)))
    period = 2 * np.mean(np.diff(crossings)) * slow.opt.timestep
    assert period == pytest.approx(2 * np.pi / np.sqrt(100), rel=0.01)


@pytest.mark.parametrize(
    ("xml", "one"),
    [
        (SLIDE, effect("friction_behind_play", half_gap=GAP, stiffness=STIFFNESS)),
        (SPRING, effect("relaxing_stiffness", share=0.3, time=0.5)),
    ],
    ids=["play", "rest"],
)
def test_a_corrected_file_can_be_read_again(xml: str, one: Effect) -> None:
    """What is written of a model with the effect is a model with it."""
    spec = edited(xml, one)
    again = mujoco.MjModel.from_xml_string((spec.compile(), spec.to_xml())[1])
    assert again.ntendon == 1
