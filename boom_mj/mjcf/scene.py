"""What the model looks like: ground, sky, light, truck, turret and tapered boxes; nothing here has mass or contact."""

import mujoco
import numpy as np

from boom_mj.machine import Elastic, Machine, sections

YELLOW = (0.93, 0.69, 0.13, 1)
"""Of the boom: red, green, blue, opacity."""
GREY, DARK = (0.55, 0.57, 0.6, 1), (0.12, 0.13, 0.15, 1)
BOX, CYLINDER, MESH = mujoco.mjtGeom.mjGEOM_BOX, mujoco.mjtGeom.mjGEOM_CYLINDER, mujoco.mjtGeom.mjGEOM_MESH


def dress(spec: mujoco.MjSpec, machine: Machine) -> None:
    """Sky, ground, light, truck and cameras of the world."""
    spec.visual.global_.offwidth, spec.visual.global_.offheight = 1920, 1080
    spec.visual.global_.azimuth, spec.visual.global_.elevation = 110, -12
    spec.visual.map.znear, spec.visual.map.zfar = 0.004, 40
    spec.visual.quality.shadowsize = 4096
    reach = sum(link.length for link in machine.links)
    spec.stat.extent, spec.stat.center = 0.75 * reach, [reach / 3, 0, machine.slewing.pivot_height]
    spec.add_texture(
        name="sky", type=mujoco.mjtTexture.mjTEXTURE_SKYBOX, builtin=mujoco.mjtBuiltin.mjBUILTIN_GRADIENT,
        rgb1=[0.62, 0.76, 0.92], rgb2=[0.95, 0.97, 1.0], width=256, height=256,
    )  # fmt: skip
    spec.add_texture(
        name="ground", type=mujoco.mjtTexture.mjTEXTURE_2D, builtin=mujoco.mjtBuiltin.mjBUILTIN_CHECKER,
        rgb1=[0.47, 0.48, 0.47], rgb2=[0.52, 0.53, 0.52], width=256, height=256,
    )  # fmt: skip
    ground = spec.add_material(name="ground", texrepeat=[1, 1], texuniform=True, specular=0.1)
    ground.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = "ground"
    world = spec.worldbody
    world.add_light(pos=[10, -20, 40], dir=[-0.1, 0.45, -0.9], type=mujoco.mjtLightType.mjLIGHT_DIRECTIONAL)
    _visual(world, mujoco.mjtGeom.mjGEOM_PLANE, size=[60, 60, 1], material="ground")
    side = np.array([reach / 2, -0.9 * reach, 7.0])
    world.add_camera(name="side", pos=side, xyaxes=[1, 0, 0, 0, 0, 1], fovy=40)
    _draw_truck(world, machine.slewing.pivot_height)


def _draw_truck(world: mujoco.MjsBody, height: float) -> None:
    """A carrier with its cab to the front; the slewing axis stands behind the cab."""
    _visual(world, BOX, pos=[-2.6, 0, 1.05], size=[5.6, 0.45, 0.16], rgba=DARK)
    _visual(world, BOX, pos=[1.9, 0, 1.95], size=[1.0, 1.22, 1.0], rgba=(0.9, 0.9, 0.92, 1))
    _visual(world, BOX, pos=[2.72, 0, 2.35], size=[0.2, 1.1, 0.42], rgba=(0.2, 0.3, 0.38, 1))
    _visual(world, BOX, pos=[-4.4, 0, 1.65], size=[2.6, 1.15, 0.45], rgba=GREY)
    _visual(world, BOX, pos=[-7.6, 0, 1.5], size=[0.5, 0.8, 0.5], rgba=YELLOW)
    _visual(world, CYLINDER, pos=[0, 0, (height - 0.5) / 2 + 0.6], size=[0.5, (height - 1.7) / 2, 0], rgba=GREY)
    for x in (2.0, -3.6, -5.0, 0.4):
        for side in (-1.05, 1.05):
            _visual(world, CYLINDER, pos=[x, side, 0.5], size=[0.5, 0.16, 0], quat=[1, 1, 0, 0], rgba=DARK)
    for x, length in ((0.9, 3.4), (-6.0, 2.6)):
        for side in (-1, 1):
            _visual(world, BOX, pos=[x, side * length / 2, 0.95], size=[0.12, length / 2, 0.12], rgba=YELLOW)
            _visual(world, CYLINDER, pos=[x, side * length, 0.5], size=[0.09, 0.45, 0], rgba=GREY)
            _visual(world, BOX, pos=[x, side * length, 0.04], size=[0.35, 0.35, 0.04], rgba=DARK)


def draw_turret(body: mujoco.MjsBody, machine: Machine) -> None:
    """Turret head and the foot of cylinder 2; the turret frame has y up and z to the right."""
    foot_x, foot_y = machine.cylinder2.base
    _visual(body, BOX, pos=[0, -0.45, 0.36], size=[0.42, 0.6, 0.06], rgba=YELLOW)
    _visual(body, BOX, pos=[0, -0.45, -0.36], size=[0.42, 0.6, 0.06], rgba=YELLOW)
    _visual(body, CYLINDER, pos=[0, -0.95, 0], size=[0.6, 0.12, 0], quat=[1, 1, 0, 0], rgba=GREY)
    _visual(body, BOX, pos=[foot_x, foot_y + 0.1, 0], size=[0.2, 0.2, 0.25], rgba=GREY)
    _visual(body, CYLINDER, size=[0.16, 0.45, 0], rgba=DARK)


def box_corners(machine: Elastic, index: int, start: float, stop: float) -> np.ndarray:
    """Corners of a link's tapered box between two x, in the link-tip frame, (8, 3), m; z changes first, x last."""
    link, corners = machine.links[index], []
    for x in (start, stop):
        height, width = sections.linear(link.height, link, x) / 2, sections.linear(link.width, link, x) / 2
        z = float(sections.offset(link, machine.offset_profile.kind, x)) - link.offset
        corners += [(x, sy * height, z + sz * width) for sy in (-1, 1) for sz in (-1, 1)]
    return np.array(corners)


def draw_segment(
    spec: mujoco.MjSpec, body: mujoco.MjsBody, machine: Elastic, index: int, number: int, start: float, stop: float
) -> None:
    """The stretch of a link's tapered box between two x, with the joint at its end drawn as a pin."""
    link = machine.links[index]
    name = f"{link.name}_box_{number + 1}"
    spec.add_mesh(name=name, uservert=np.round(box_corners(machine, index, start, stop), 6).ravel())
    _visual(body, MESH, meshname=name, rgba=YELLOW if index % 2 == 0 else (0.96, 0.76, 0.2, 1))
    if stop == 0.0 and index + 1 < len(machine.links):
        radius = 0.55 * link.height[1]
        _visual(body, CYLINDER, pos=[0, 0, 0], size=[radius, 0.65 * link.width[0], 0], rgba=GREY)


def _visual(body: mujoco.MjsBody, kind: mujoco.mjtGeom, **attributes: object) -> None:
    body.add_geom(type=kind, contype=0, conaffinity=0, group=1, mass=0, **attributes)
