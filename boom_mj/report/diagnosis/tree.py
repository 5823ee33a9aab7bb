"""An MJCF machine as the tree of its bodies, with joints, actuators and sensors coloured by where the gap is sensed."""

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
from matplotlib.colors import LogNorm, to_hex

from boom_mj.report.diagnosis.view import Change, View
from boom_mj.report.drawing import HEAT
from boom_mj.systems.mjcf import MjcfSystem
from boom_mj.systems.mjcf.rollout import joint_of
from boom_mj.systems.mjcf.sites import links

ROLES = {
    "drive": "its measured motion drives",
    "control": "commanded",
    "compare": "judged",
    "temperature": "its temperature",
}


@dataclass(frozen=True)
class Part:
    """A part of the machine: how deep it lies in the tree, its name, and what it is."""

    depth: int
    name: str
    kind: str


@dataclass(frozen=True)
class Row:
    """A part, what the log has of it, its held-out gaps with their colours, and the explanation's effects there."""

    part: Part
    logged: str
    change: Change | None
    before: str
    after: str
    effects: Sequence[str]


def picture(view: View, system: MjcfSystem) -> Mapping[str, Any]:
    """What `tree.html` shows."""
    places = [system.entries[channel.group].place for channel in view.data.channels]
    changes = view.changes(places, view.data.held_out)
    norm = LogNorm(1.0, max(10.0, *(change.before for change in changes.values())) if changes else 10.0)
    logged, named = defaultdict(list), defaultdict(list)
    for entry in system.channels.channel:
        logged[entry.place].append(f"{entry.name}: {ROLES[entry.role]}")
    owner = {entry.name: entry.place for entry in system.channels.channel}
    for effect in view.effects:
        for place in effect.location.values():
            named[owner.get(str(place), str(place))].append(effect.id.replace("_", " "))
    rows = [
        Row(
            part,
            "; ".join(logged[part.name] if part.kind != "body" else ()),
            change := changes.get(part.name) if part.kind != "body" else None,
            _colours(norm, change.before if change else np.nan),
            _colours(norm, change.after if change else np.nan),
            named[part.name],
        )
        for part in parts(system)
    ]
    whole = [effect.id.replace("_", " ") for effect in view.effects if not effect.location]
    return {"rows": rows, "whole": whole, "corrected": view.corrected}


def parts(system: MjcfSystem) -> Iterator[Part]:
    """Bodies, root outward, each followed by what sits on it; a chain of hinges of a flexible link is one part."""
    model, flexible = system.spec.copy().compile(), links(system.spec)
    children, hosts, moved = defaultdict(list), defaultdict(list), defaultdict(list)
    for body in range(1, model.nbody):
        children[int(model.body_parentid[body])].append(body)
    for entry in system.channels.channel:
        if entry.sensor:
            hosts[_host(model, model.sensor(entry.sensor).id)].append(entry.sensor)
    for actuator in system.spec.actuators:
        moved[joint_of(system.spec, actuator.name)].append(actuator.name)

    def walk(body: int, depth: int) -> Iterator[Part]:
        joints = [model.joint(int(model.body_jntadr[body]) + k).name for k in range(int(model.body_jntnum[body]))]
        chains = {joint.partition("/")[0] for joint in joints} & flexible
        inner = chains and not any(joint.endswith("/1") for joint in joints)
        if not inner:
            yield Part(depth, model.body(body).name or f"body {body}", "body")
            for chain in chains:
                count = sum(joint.name.startswith(f"{chain}/") for joint in system.spec.joints)
                yield Part(depth + 1, chain, f"flexible link of {count} hinges")
            for joint in joints:
                if joint.partition("/")[0] not in flexible:
                    slides = model.joint(joint).type[0] == int(mujoco.mjtJoint.mjJNT_SLIDE)
                    yield Part(depth + 1, joint, "slide" if slides else "joint")
                    yield from (Part(depth + 2, actuator, "actuator") for actuator in moved[joint])
        yield from (Part(depth + 1, sensor, "sensor") for sensor in dict.fromkeys(hosts[body]))
        for child in children[body]:
            yield from walk(child, depth if inner or chains else depth + 1)

    for child in children[0]:
        yield from walk(child, 0)
    yield from (Part(0, name, "sensor") for name in dict.fromkeys(hosts[0]))
    yield from (Part(0, name, "actuator") for name in moved[""])


def _host(model: mujoco.MjModel, sensor: int) -> int:
    """The body that a sensor sits on, 0 (the world) where it sits on none."""
    kind, number = int(model.sensor_objtype[sensor]), int(model.sensor_objid[sensor])
    owners = {
        mujoco.mjtObj.mjOBJ_SITE: model.site_bodyid,
        mujoco.mjtObj.mjOBJ_GEOM: model.geom_bodyid,
        mujoco.mjtObj.mjOBJ_JOINT: model.jnt_bodyid,
        mujoco.mjtObj.mjOBJ_BODY: np.arange(model.nbody),
        mujoco.mjtObj.mjOBJ_XBODY: np.arange(model.nbody),
    }
    of = owners.get(mujoco.mjtObj(kind))
    return int(of[number]) if of is not None else 0


def _colours(norm: LogNorm, gap: float) -> str:
    """Background and ink of a gap as CSS; nothing where there is none."""
    if not np.isfinite(gap):
        return ""
    depth = float(np.clip(norm(max(gap, 1.0)), 0, 1))
    return f"background: {to_hex(HEAT(depth))}; color: {'#ffffff' if depth > 0.8 else '#222222'}"
