"""Places of a MuJoCo specification, found by their names, and what effects do to them."""

from collections.abc import Iterator
from itertools import pairwise

import mujoco
import numpy as np
from scipy.spatial.transform import Rotation

from boom_mj.engine import mass_matrix
from boom_mj.machine import Machine
from boom_mj.machine.shapes import STIFFNESS

Array = np.ndarray
ARMATURE = 1.0  # kg m^2, far below any link, so that a mass matrix without the drive's own stays regular
SLIM = 1e-3  # armature of a series joint over the inertia behind it
BRAKE = "friction"  # tendon JOINT/friction: the joint's friction behind play
LEAST_YIELD = 1e-12  # m or rad
LIGHT = 1e-9  # kg, kg m^2
FLAT = 1e-6  # least extent of a body over its largest, squared
SEATS = ("payload", "tip", "attachment_site")  # sites where a payload is carried


BASE_AXES = {"roll": [1.0, 0.0, 0.0], "pitch": [0.0, 1.0, 0.0]}


def tilt_base(spec: mujoco.MjSpec, roll: float, pitch: float) -> None:
    """Gravity, and what stands on the ground, turned (further) against a machine that rolls, then pitches, rad."""
    ground, tilt = spec.site("world"), Rotation.from_euler("xy", [roll, pitch]).inv()
    spec.option.gravity = tilt.apply(spec.option.gravity)
    ground.quat = (tilt * Rotation.from_quat(ground.quat, scalar_first=True)).as_quat(scalar_first=True)


def spring_base(spec: mujoco.MjSpec, machine: Machine, axis: str, stiffness: float) -> mujoco.MjsJoint:
    """The hinge, at the origin, about which a machine rolls or pitches on springs, N m/rad, one after the other."""
    base, spring = spec.body("base"), spec.joint(f"base_{axis}")
    if spring is None:
        base.explicitinertial, base.ipos = True, [0.0, 0.0, 0.0]
        base.mass, base.inertia = 1.0, [1.0, 1.0, 1.0]  # a moving body has some
        spring = base.add_joint(name=f"base_{axis}", axis=BASE_AXES[axis])
        spring.stiffness[0] = stiffness
    else:
        spring.stiffness = spring.stiffness * stiffness / (stiffness + spring.stiffness[0])
    spring.damping[0] = machine.damping.relaxation_time * spring.stiffness[0]
    return spring


def link_bodies(spec: mujoco.MjSpec, link: int) -> list[mujoco.MjsBody]:
    """Rigid segments of a link, root outward."""
    found, number = [spec.body(f"link{link}")], 2
    while (body := spec.body(f"link{link}_{number}")) is not None:
        found.append(body)
        number += 1
    return found


def link_hinges(spec: mujoco.MjSpec, link: int, axis: str) -> list[mujoco.MjsJoint]:
    """Equivalent hinges of one coordinate (v, w or torsion) of a link, root outward."""
    found: list[mujoco.MjsJoint] = []
    while (joint := spec.joint(f"link{link}_{axis}_{len(found) + 1}")) is not None:
        found.append(joint)
    return found


def elastic_hinges(spec: mujoco.MjSpec, machine: Machine) -> Iterator[mujoco.MjsJoint]:
    """Every equivalent hinge."""
    for number in range(2, 2 + len(machine.links)):
        for axis in ("v", "w", "torsion"):
            yield from link_hinges(spec, number, axis)


def stretches(spec: mujoco.MjSpec, machine: Machine, link: int) -> list[tuple[mujoco.MjsBody, float, float]]:
    """Segments of a link with the x between which they lie, m: they meet midway between the bending hinges there."""
    bodies = link_bodies(spec, link)
    bending = {hinge.name: hinge for axis in ("v", "w") for hinge in link_hinges(spec, link, axis)}
    seams = [[hinge.pos[0] for hinge in body.joints if hinge.name in bending] for body in bodies[1:]]
    cuts = [-machine.links[link - 2].length, *(float(sum(seam) / len(seam)) for seam in seams), 0.0]
    return [(body, start, stop) for body, (start, stop) in zip(bodies, pairwise(cuts))]


def bent_by(spec: mujoco.MjSpec, machine: Machine, link: int, axis: str) -> list[tuple[mujoco.MjsJoint, float]]:
    """Hinges of v or w of a link, each with the length of link whose bend it gathers, m: E I / stiffness."""
    own = machine.links[link - 2]
    return [(h, float(STIFFNESS[axis](own, h.pos[0])) / h.stiffness[0]) for h in link_hinges(spec, link, axis)]


def second_moment(body: mujoco.MjsBody) -> Array:
    """Second moment of a body's mass about its centre, (3, 3), kg m^2."""
    xx, yy, zz, xy, xz, yz = body.fullinertia
    tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    return np.trace(tensor) / 2 * np.eye(3) - tensor


def set_second_moment(body: mujoco.MjsBody, moment: Array) -> None:
    """The inertia of a body by the second moment of its mass, (3, 3), kg m^2."""
    size, axes = np.linalg.eigh(moment)
    moment = (axes * np.maximum(size, FLAT * size.max())) @ axes.T  # nothing is thinner than flat
    tensor = np.trace(moment) * np.eye(3) - moment
    body.fullinertia = [*np.diag(tensor), tensor[0, 1], tensor[0, 2], tensor[1, 2]]


def add_series_hinge(spec: mujoco.MjSpec, joint: int, name: str) -> mujoco.MjsJoint:
    """A free hinge between a drive and the link that it turns, about the same axis."""
    drive = spec.joint(f"joint{joint}")
    return drive.parent.add_joint(name=name, pos=drive.pos, axis=drive.axis, armature=ARMATURE)


def chain(spec: mujoco.MjSpec, link: str) -> list[mujoco.MjsJoint]:
    """Sprung joints LINK/1, LINK/2, ... that stand for the bending of a flexible link, root outward."""
    found: list[mujoco.MjsJoint] = []
    while (joint := spec.joint(f"{link}/{len(found) + 1}")) is not None:
        found.append(joint)
    return found


def add_friction(spec: mujoco.MjSpec, joint: str, force: float) -> None:
    """Dry friction of a joint, N or N m, with a constraint so stiff that it creeps little; behind its play, if any."""
    if force:
        if (brake := spec.tendon(f"{joint}/{BRAKE}")) is not None:
            brake.springyield = max(brake.springyield + force / brake.stiffness[0], LEAST_YIELD)
            return
        rubbing = spec.joint(joint)
        rubbing.frictionloss += force
        rubbing.solref_friction = (2 * spec.option.timestep, 1.0)
        rubbing.solimp_friction = (0.99, 0.999, 0.001, 0.5, 2.0)


def move_friction_behind(spec: mujoco.MjSpec, joint: str, half_gap: float, stiffness: float) -> None:
    """A joint's dry friction behind play (m or rad either way) and a spring (N/m or N m/rad)."""
    rubbing, brake = spec.joint(joint), spec.add_tendon(name=f"{joint}/{BRAKE}")
    brake.wrap_joint(joint, 1.0)
    brake.stiffness[0], brake.springlength = stiffness, [-half_gap, half_gap]
    brake.springyield = max(rubbing.frictionloss / stiffness, LEAST_YIELD)  # 0 would be elastic
    rubbing.frictionloss = 0.0


def add_relaxation(spec: mujoco.MjSpec, joint: mujoco.MjsJoint, share: float, time: float) -> None:
    """A share of a joint's stiffness on a dashpot: a spring between the joint and a damped one that weighs nothing."""
    name, stiffness = f"{joint.name}/relaxed", share * float(joint.stiffness[0])
    dashpot = spec.worldbody.add_body(name=name, gravcomp=1.0)
    dashpot.mass, dashpot.ipos, dashpot.inertia, dashpot.explicitinertial = LIGHT, np.zeros(3), np.full(3, LIGHT), True
    follower = dashpot.add_joint(name=name, type=joint.type, axis=joint.axis, ref=joint.ref)
    follower.damping[0] = stiffness * time
    follower.armature = stiffness * (2 * spec.option.timestep) ** 2
    between = spec.add_tendon(name=name)
    between.wrap_joint(joint.name, 1.0)
    between.wrap_joint(name, -1.0)
    between.stiffness[0], between.springlength = stiffness, [0.0, 0.0]
    joint.stiffness[0] -= stiffness


def add_constant_force(spec: mujoco.MjSpec, joint: str, force: float) -> None:
    """A force on a joint that is always there, N or N m."""
    push = spec.add_actuator(name=f"push/{joint}", target=joint, trntype=mujoco.mjtTrn.mjTRN_JOINT)
    push.gaintype, push.biastype = mujoco.mjtGain.mjGAIN_FIXED, mujoco.mjtBias.mjBIAS_AFFINE
    push.gainprm[0], push.biasprm[0] = 0.0, force


def add_series_joint(spec: mujoco.MjSpec, joint: str, kind: str, half_gap: float = 0.0, stiffness: float = 0.0) -> None:
    """A joint behind another of the same axis: free within a gap, or sprung with critical damping over four."""
    drive = spec.joint(joint)
    behind = _inertia(spec, joint)
    series = drive.parent.add_joint(name=f"{joint}/{kind}", type=drive.type, pos=drive.pos, axis=drive.axis)
    series.armature = SLIM * behind
    if half_gap:
        series.limited, series.range = mujoco.mjtLimited.mjLIMITED_TRUE, (-half_gap, half_gap)
        series.solref_limit = (2 * spec.option.timestep, 1.0)
    if stiffness:
        series.stiffness[0], series.damping[0] = stiffness, 0.5 * np.sqrt(stiffness * behind)


def _inertia(spec: mujoco.MjSpec, joint: str) -> float:
    """That a joint turns (or moves), as compiled, without its own armature."""
    model = spec.copy().compile()
    mass = mass_matrix(model)
    dof = model.joint(joint).dofadr[0]
    return max(float(mass[dof, dof] - model.dof_armature[dof]), 1e-9)


def scale_mass(body: mujoco.MjsBody, factor: float) -> None:
    """Mass and inertia of a body by a factor, whether it has them itself or from its geoms."""
    if body.explicitinertial:
        body.mass *= factor
        body.inertia = np.asarray(body.inertia) * factor
        if np.isfinite(body.fullinertia).all():
            body.fullinertia = np.asarray(body.fullinertia) * factor
        return
    for geom in body.geoms:
        geom.density *= factor
        if np.isfinite(geom.mass):
            geom.mass *= factor


def add_mass(spec: mujoco.MjSpec, body: str, mass: float) -> None:
    """A point mass (a ball of 1 mm) carried by a body."""
    host = spec.body(body)
    seats = [site.pos for site in host.sites if site.name.rpartition("/")[2] in SEATS]
    place = seats[0] if seats else spec.copy().compile().body(body).ipos
    load = host.add_body(name=f"{body}/payload", pos=np.array(place))
    load.mass, load.ipos, load.inertia, load.explicitinertial = mass, np.zeros(3), np.full(3, mass * 4e-7), True


def add_point_mass(site: mujoco.MjsSite, name: str, mass: float, gravcomp: float = 0.0) -> None:
    """A point mass (some cm) on a site, of whose weight a share is compensated."""
    load = site.parent.add_body(name=name, explicitinertial=True, gravcomp=gravcomp)
    load.mass, load.ipos, load.inertia = mass, site.pos, [1e-3, 1e-3, 1e-3]


def turn_gravity(spec: mujoco.MjSpec, roll: float, pitch: float) -> None:
    """Gravity in a base that is turned about its x, then its y, rad."""
    if roll or pitch:
        (x, y, z), c, s = spec.option.gravity, np.cos, np.sin
        y, z = c(roll) * y + s(roll) * z, -s(roll) * y + c(roll) * z
        x, z = c(pitch) * x - s(pitch) * z, s(pitch) * x + c(pitch) * z
        spec.option.gravity = (x, y, z)
