"""The machine as an MJCF model: a chain of rigid segments joined by drives and equivalent hinges.

Frames: world z up; every body of a link carries the link-tip frame (x along the link, y its vertical bending direction,
z to the right), so that positions in the file read as the x in [-length, 0] of the equations.
"""

from dataclasses import dataclass

import mujoco
import numpy as np
from scipy.linalg import eigvalsh

from boom_mj.engine import mass_matrix
from boom_mj.errors import MachineFileError, numbers_of
from boom_mj.machine import AXES, Elastic, Machine
from boom_mj.mjcf import scene
from boom_mj.mjcf.hinges import HingeChain, hinge_chains, seams
from boom_mj.mjcf.inertia import RigidInertia, beam_axis, segment_inertias
from boom_mj.mjcf.keyframes import POSES_DEG, add_keyframes
from boom_mj.mjcf.rayleigh import in_tune

Array = np.ndarray
TIMESTEP = 0.005  # s, the longest; docs/explanation/integrators.md says why
STABLE_PHASE = 1.2  # omega h of the fastest hinge, with a margin to 2 for other poses
DRIVE_FREQUENCY = 8.0  # Hz: servo of the drives as the file holds them, against the inertia of the stretched boom


@dataclass(frozen=True)
class BoomModel:
    """A machine's MJCF model before compilation, and how its hinges stand for Ritz coordinates.

    Attributes:
        machine: what it was built from.
        spec: MuJoCo model specification; `compile()` gives the model.
        chains: per link the hinge chains `torsion`, `v`, `w`.
    """

    machine: Machine
    spec: mujoco.MjSpec
    chains: tuple[dict[str, HingeChain], ...]

    def compile(self) -> mujoco.MjModel:
        """The specification as MuJoCo runs it."""
        with numbers_of(self.machine.name, MachineFileError):
            return self.spec.compile()

    def to_xml(self) -> str:
        """The MJCF text, with keyframes and sensors of joints and tip beside what simulations need."""
        self.compile()
        spec = self.spec.copy()
        add_keyframes(spec, {name: np.radians(pose) for name, pose in POSES_DEG.items()})
        add_readings(spec)
        spec.compile()
        return spec.to_xml()

    def ritz_matrix(self, model: mujoco.MjModel) -> Array:
        """Rows (12, nq) with elastic Ritz coordinates = matrix @ qpos, in the order qa2, qv2, qw2, ..., qw5."""
        rows = np.zeros((3 * len(self.chains), model.nq))
        for row, chain in zip(rows, (link[axis] for link in self.chains for axis in AXES)):
            row[[model.joint(name).qposadr[0] for name in chain.joint_names]] = chain.readback
        return rows

    def shape_matrix(self, model: mujoco.MjModel) -> Array:
        """Columns (nq, 12): hinge angles when each elastic Ritz coordinate is 1."""
        columns = np.zeros((model.nq, 3 * len(self.chains)))
        for k, chain in enumerate(link[axis] for link in self.chains for axis in AXES):
            columns[[model.joint(n).qposadr[0] for n in chain.joint_names], k] = [h.gain for h in chain.hinges]
        return columns


def build(machine: Machine, hinges: int = 1, drawn: bool = True) -> BoomModel:
    """MuJoCo model of a machine with `hinges` equivalent hinges per elastic coordinate of each link.

    What is only to be looked at can be left out: the same motion costs a twentieth less and compiles twice as fast.

    Joints `joint1`..`joint5`, elastic hinges `link2_v_1`, ..; sites `tip`, `imu_link2`.., `marker1`..; actuators
    `drive1`..`drive5` (servo to a joint angle in rad) and `rope_x`, `rope_y`, `rope_z` (force on the tip, world, N).

    Raises:
        MachineFileError: numbers that make no model.
    """
    with numbers_of(machine.name, MachineFileError):
        return _built(machine, hinges, drawn)


def _built(machine: Machine, hinges: int, drawn: bool) -> BoomModel:
    spec = mujoco.MjSpec()
    spec.modelname = machine.name
    spec.compiler.degree = False
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.option.gravity = [0, 0, -machine.gravity]

    base = spec.worldbody.add_body(name="base")
    turret = base.add_body(name="turret", pos=[0, 0, machine.slewing.pivot_height], quat=[1, 1, 0, 0])
    set_inertia(
        turret, RigidInertia(1e-3, np.zeros(3), 1e-3 * np.eye(3))
    )  # turns with a drive: its inertia is no matter
    if drawn:
        scene.draw_turret(turret, machine)
    _add_drive(turret, machine, 0, np.zeros(3), np.array([0.0, 1.0, 0.0]))

    chains, body = hinge_chains(machine, hinges), turret
    if hinges == 1:
        chains = in_tune(machine, chains)
    for index in range(len(machine.links)):
        body = _add_link(spec, body, machine, index, chains[index], drawn)
    body.add_site(name="tip", size=[0.06, 0, 0], rgba=[0.9, 0.2, 0.1, 1])

    _add_sensors(spec, machine)
    spec.worldbody.add_site(name="world", size=[0.01, 0, 0])
    for k, axis in enumerate("xyz"):
        rope = spec.add_actuator(name=f"rope_{axis}", target="tip", refsite="world", trntype=mujoco.mjtTrn.mjTRN_SITE)
        rope.gear = np.eye(6)[k]
    _tune_drives(spec, machine)
    spec.option.timestep = stable_step(spec, machine)
    if drawn:
        scene.dress(spec, machine)  # last: what comes before compiles faster without it
    return BoomModel(machine, spec, chains)


def _add_link(
    spec: mujoco.MjSpec,
    parent: mujoco.MjsBody,
    machine: Machine,
    index: int,
    chains: dict[str, HingeChain],
    drawn: bool,
) -> mujoco.MjsBody:
    """Bodies of one link, root outward; returns the outermost, which carries the tip."""
    link, paper = machine.links[index], len(chains["v"].hinges) == 1
    axis = np.array([1.0, 0.0, 0.0]) if paper else beam_axis(machine, index)
    across = {"torsion": axis, "v": np.array([-axis[2], 0.0, axis[0]]), "w": np.array([0.0, -1.0, 0.0])}
    inertias, joints = segment_inertias(machine, index, chains), seams(link, chains)
    cuts = [-link.length, *(seam.place for seam in joints), 0.0]
    markers = np.array(machine.sensors.markers_x) * link.length
    body = parent
    for k, inertia in enumerate(inertias):
        root = np.array([link.length, 0.0, link.offset])
        body = body.add_body(name=link.name if k == 0 else f"{link.name}_{k + 1}", pos=root if k == 0 else [0, 0, 0])
        set_inertia(body, inertia)
        if k == 0:
            _add_drive(body, machine, index + 1, -root, np.array([0.0, 0.0, 1.0]))
        for name, number in joints[k - 1].hinges.items() if k else ():
            hinge = chains[name].hinges[number]
            joint = body.add_joint(name=chains[name].joint_names[number], axis=across[name])
            joint.pos = [hinge.position, 0.0, 0.0] if paper else _on_axis(machine, index, hinge.position)
            joint.stiffness[0], joint.damping[0] = hinge.stiffness, hinge.damping
        if drawn:
            scene.draw_segment(spec, body, machine, index, k, cuts[k], cuts[k + 1])
        for number, x in enumerate(markers):
            if cuts[k] <= x < cuts[k + 1] or (x == 0.0 and k == len(inertias) - 1):
                name = f"marker{len(markers) * index + number + 1}"
                body.add_site(name=name, pos=_on_axis(machine, index, x), size=[0.05, 0, 0], rgba=[1, 0.85, 0, 1])
    body.add_site(name=f"imu_{link.name}", size=[0.03, 0, 0], rgba=[0.1, 0.4, 0.9, 1])
    return body


def _on_axis(machine: Machine, index: int, x: float) -> Array:
    """Point of the neutral axis in the link-tip frame, (3,), m."""
    link = machine.links[index]
    ramp = machine.offset_profile.kind == "ramp"
    return np.array([x, 0.0, link.offset * x / link.length if ramp else 0.0])


def _add_drive(body: mujoco.MjsBody, machine: Machine, number: int, pos: Array, axis: Array) -> None:
    drive, name = machine.drives[number], f"joint{number + 1}"
    joint = body.add_joint(name=name, pos=pos, axis=axis, range=drive.range)
    joint.damping[0] = drive.viscous_friction


def _add_sensors(spec: mujoco.MjSpec, machine: Machine) -> None:
    """Ideal sensors in the order of their names: IMUs at the link tips, marker positions; noise is not MuJoCo's."""
    for link in machine.links:
        for kind in ("accelerometer", "gyro"):
            spec.add_sensor(
                name=f"{kind}_{link.name}",
                type=getattr(mujoco.mjtSensor, f"mjSENS_{kind.upper()}"),
                objtype=mujoco.mjtObj.mjOBJ_SITE,
                objname=f"imu_{link.name}",
            )
    for number in range(len(machine.links) * len(machine.sensors.markers_x)):
        marker = f"marker{number + 1}"
        site, position = mujoco.mjtObj.mjOBJ_SITE, mujoco.mjtSensor.mjSENS_FRAMEPOS
        spec.add_sensor(name=marker, type=position, objtype=site, objname=marker)


def add_readings(spec: mujoco.MjSpec) -> None:
    """Sensors for those who open the file: joint1_position, joint1_velocity, drive1_torque, .., tip_position."""
    kinds = mujoco.mjtSensor
    for k in range(1, 6):
        joint, drive = (mujoco.mjtObj.mjOBJ_JOINT, f"joint{k}"), (mujoco.mjtObj.mjOBJ_ACTUATOR, f"drive{k}")
        for name, kind, (objtype, objname) in (
            (f"joint{k}_position", kinds.mjSENS_JOINTPOS, joint),
            (f"joint{k}_velocity", kinds.mjSENS_JOINTVEL, joint),
            (f"drive{k}_torque", kinds.mjSENS_ACTUATORFRC, drive),
        ):
            spec.add_sensor(name=name, type=kind, objtype=objtype, objname=objname)
    site = mujoco.mjtObj.mjOBJ_SITE
    spec.add_sensor(name="tip_position", type=kinds.mjSENS_FRAMEPOS, objtype=site, objname="tip")


def _tune_drives(spec: mujoco.MjSpec, machine: Machine) -> None:
    """Position servos stiff enough to hold the stretched boom, in the order of the joints, before the rope."""
    model = spec.compile()
    inertia = mass_matrix(model)
    for number, drive in enumerate(machine.drives):
        omega = 2 * np.pi * DRIVE_FREQUENCY
        own = float(inertia[model.joint(f"joint{number + 1}").dofadr[0]][model.joint(f"joint{number + 1}").dofadr[0]])
        servo = spec.add_actuator(
            name=f"drive{number + 1}",
            target=f"joint{number + 1}",
            trntype=mujoco.mjtTrn.mjTRN_JOINT,
            ctrlrange=drive.range,
            ctrllimited=True,
        )
        servo.set_to_position(kp=own * omega**2, kv=1.4 * own * omega)


def stable_step(spec: mujoco.MjSpec, machine: Elastic) -> float:
    """TIMESTEP, or the largest whole fraction of it at which the fastest hinge is stable.

    Springs are integrated explicitly, which bears omega h < 2; their damping implicitly, which from a relaxation time
    of h / 2 on bears any omega.
    """
    if machine.damping.relaxation_time >= TIMESTEP / 2:
        return TIMESTEP
    model = spec.compile()
    mass = mass_matrix(model)
    elastic = np.flatnonzero(model.jnt_stiffness.reshape(model.njnt, -1)[:, 0])
    stiffness = model.jnt_stiffness.reshape(model.njnt, -1)[elastic, 0]
    fastest = np.sqrt(eigvalsh(np.diag(stiffness), mass[np.ix_(elastic, elastic)])[-1])
    return TIMESTEP / int(np.ceil(TIMESTEP * fastest / STABLE_PHASE))


def set_inertia(body: mujoco.MjsBody, inertia: RigidInertia) -> None:
    """Mass, centre of mass and inertia of a body in its own frame."""
    tensor = inertia.tensor
    body.explicitinertial = True
    body.mass, body.ipos = inertia.mass, inertia.center
    body.fullinertia = [*np.diag(tensor), tensor[0, 1], tensor[0, 2], tensor[1, 2]]
