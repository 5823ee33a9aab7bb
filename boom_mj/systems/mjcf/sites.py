"""Where effects can be in an MJCF machine, and what sizes are typical there."""

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import mujoco
import numpy as np

from boom_mj.effects.general_effect import Typical
from boom_mj.recording import Recording
from boom_mj.systems.mjcf.rollout import Run

if TYPE_CHECKING:
    from boom_mj.systems.mjcf.system import MjcfSystem

Array = np.ndarray
Place = tuple[str, frozenset[str], Typical]
TINY = 1e-9


def places_of(robot: "MjcfSystem", where: str, logs: Sequence[Recording], runs: Sequence[Run]) -> Iterator[Place]:
    """Names, tags and typical sizes of every place of a kind; "" is the machine as a whole."""
    kinds = {
        "joint": _joints,
        "link": _links,
        "body": _bodies,
        "actuator": _actuators,
        "channel": _channels,
        "": _whole,
    }
    return kinds[where](robot, logs, runs)


def _joints(robot: "MjcfSystem", logs: Sequence[Recording], runs: Sequence[Run]) -> Iterator[Place]:
    model, channels = robot.spec.copy().compile(), robot.channels
    data, mass = mujoco.MjData(model), np.zeros((model.nv, model.nv))
    mujoco.mj_forward(model, data)
    mujoco.mj_fullM(model, data, mass)
    measured = {e.joint for e in channels.channel if e.joint and e.what == "position"}
    actuated = {robot.joint_of(e.actuator) for e in channels.channel if e.actuator} | set(channels.driven)
    for name in runs[0].position:
        if name.partition("/")[0] in links(robot.spec):
            continue
        joint = model.joint(name)
        dof = int(joint.dofadr[0])
        inertia = float(mass[dof, dof])
        stiffness, damping = float(model.jnt_stiffness[joint.id]), float(np.ravel(model.dof_damping[dof])[0])
        position, speed = _motion(robot, name, logs, runs)
        span = max(float(np.ptp(position)), TINY)
        fast = max(_rms(speed), TINY)
        forces = [inertia * _rms(np.concatenate([run.acceleration[name] for run in runs])), stiffness * span / 4]
        forces += [
            abs(model.actuator(e.actuator).gear[0]) * _rms(_logged(e.name, logs))
            for e in channels.role("compare")
            if e.actuator and robot.joint_of(e.actuator) == name
        ]
        forces += [
            _rms(np.concatenate([run.force[e.actuator] for run in runs]))
            for e in channels.role("control")
            if robot.joint_of(e.actuator) == name
        ]
        tags = {"driven"} if name in channels.driven else {"free"}
        tags |= {"measured"} if name in measured else set()
        tags |= {"actuated"} if name in actuated else set()
        tags |= {"sprung"} if stiffness else set()
        tags |= {"outermost"} if model.body_jntnum[_behind(model, int(joint.bodyid[0]))].sum() == 1 else set()
        unit = "m" if joint.type[0] == int(mujoco.mjtJoint.mjJNT_SLIDE) else "rad"
        yield (
            name,
            frozenset(tags),
            Typical(unit, max(*forces, TINY), span, fast, inertia, damping, stiffness, float(model.dof_armature[dof])),
        )


def _behind(model: mujoco.MjModel, body: int) -> list[int]:
    """A body and all that it carries."""
    found = [body]
    for child in range(body + 1, model.nbody):
        found += [child] if int(model.body_parentid[child]) in found else []
    return found


def links(spec: mujoco.MjSpec) -> set[str]:
    """Flexible links: names LINK of chains of joints LINK/1, LINK/2, ..."""
    return {joint.name.partition("/")[0] for joint in spec.joints if joint.name.endswith("/1")}


def _links(robot: "MjcfSystem", logs: Sequence[Recording], runs: Sequence[Run]) -> Iterator[Place]:
    for name in sorted(links(robot.spec)):
        yield name, frozenset(), Typical()


def _motion(robot: "MjcfSystem", joint: str, logs: Sequence[Recording], runs: Sequence[Run]) -> tuple[Array, Array]:
    """Measured position and speed of a joint where there are any, else simulated ones."""
    names = [e.name for e in robot.channels.role("drive") if e.joint == joint]
    names += [f"motion/{joint}"] if f"motion/{joint}" in logs[0] else []
    if not names:
        return np.concatenate([run.position[joint] for run in runs]), np.concatenate(
            [run.velocity[joint] for run in runs]
        )
    signals = [log[names[0]] for log in logs]
    speeds = [np.gradient(s.values[:, 0], s.time) for s in signals]
    return np.concatenate([s.values[:, 0] for s in signals]), np.concatenate(speeds)


def _bodies(robot: "MjcfSystem", logs: Sequence[Recording], runs: Sequence[Run]) -> Iterator[Place]:
    model = robot.spec.copy().compile()
    for k in range(1, model.nbody):
        if model.body_weldid[k] != 0 and model.body_mass[k] > 0:
            leaf = not np.any(model.body_parentid[k + 1 :] == k)
            inner = model.body_jntnum[k] and model.joint(model.body_jntadr[k]).name.partition("/")[0] in links(
                robot.spec
            )
            tags = frozenset({*({"leaf"} if leaf else ()), *(() if inner else {"whole"})})
            yield model.body(k).name, tags, Typical("kg", mass=float(model.body_mass[k]))


def _actuators(robot: "MjcfSystem", logs: Sequence[Recording], runs: Sequence[Run]) -> Iterator[Place]:
    for entry in robot.channels.channel:
        judged = entry.role == "compare" and robot.joint_of(entry.actuator) in robot.channels.driven
        if entry.actuator and (entry.role == "control" or judged):
            size = max(_rms(_logged(entry.name, logs)), TINY)
            yield entry.actuator, frozenset(), Typical(entry.unit, size, step=_step(entry.name, logs))


def _channels(robot: "MjcfSystem", logs: Sequence[Recording], runs: Sequence[Run]) -> Iterator[Place]:
    for entry in robot.channels.channel:
        if entry.role != "control":
            values = _logged(entry.name, logs)
            tags = {"compared"} if entry.role == "compare" else {"driving"}
            tags |= set() if entry.actuator else {"motion"}
            size = max(float(np.std(values[np.isfinite(values)])), TINY)
            yield entry.name, frozenset(tags), Typical(entry.unit, size, step=_step(entry.name, logs))


def _whole(robot: "MjcfSystem", logs: Sequence[Recording], runs: Sequence[Run]) -> Iterator[Place]:
    heavy = bool(np.any(np.asarray(robot.spec.option.gravity)))
    yield "", frozenset({"heavy"} if heavy else ()), Typical()


def _logged(name: str, logs: Sequence[Recording]) -> Array:
    return np.concatenate([log[name].values[:, 0] for log in logs])


def _step(name: str, logs: Sequence[Recording]) -> float:
    return float(np.median(np.diff(logs[0][name].time)))


def _rms(values: Array) -> float:
    return float(np.sqrt(np.nanmean(np.square(values))))
