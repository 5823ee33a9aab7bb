"""The rigid chain as URDF, for tools that know nothing of elastic hinges: masses, limits, boxes to look at.

URDF has no springs at joints, so that the boom does not bend there: its tip hangs lower in the MJCF model.
"""

from xml.etree import ElementTree

import numpy as np

from boom_mj.machine import Machine
from boom_mj.mjcf.inertia import rigid_link
from boom_mj.mjcf.scene import YELLOW

Array = np.ndarray
STRONGEST = "1e7"  # N m, more than any drive gives: URDF asks for a limit that machine files do not tell


def urdf_text(machine: Machine) -> str:
    """URDF of a machine: links base, turret, link2..link5, tip; joints joint1..joint5, as the MJCF model names them.

    A link's frame lies at its joint, x along the link, y up when it is stretched, z to the right.
    """
    robot = ElementTree.Element("robot", name=machine.name)
    colour = ElementTree.SubElement(ElementTree.SubElement(robot, "material", name="boom"), "color")
    colour.set("rgba", _numbers(YELLOW))
    ElementTree.SubElement(robot, "link", name="base")
    _inertial(ElementTree.SubElement(robot, "link", name="turret"), 1e-3, np.zeros(3), 1e-3 * np.eye(3))
    turret = np.array([0.0, 0.0, machine.slewing.pivot_height])
    _joint(robot, machine, 0, "base", "turret", turret, (np.pi / 2, 0.0, 0.0), (0, 1, 0))
    parent, place = "turret", np.zeros(3)
    for index, link in enumerate(machine.links):
        element = ElementTree.SubElement(robot, "link", name=link.name)
        root = np.array([link.length, 0.0, link.offset])  # of the link-tip frame, seen from the joint
        whole = rigid_link(machine, index)
        _inertial(element, whole.mass, whole.center + root, whole.tensor)
        visual = ElementTree.SubElement(element, "visual")
        ElementTree.SubElement(visual, "origin", xyz=_numbers(root / 2), rpy="0 0 0")
        size = (link.length, float(np.mean(link.height)), float(np.mean(link.width)))
        ElementTree.SubElement(ElementTree.SubElement(visual, "geometry"), "box", size=_numbers(size))
        ElementTree.SubElement(visual, "material", name="boom")
        _joint(robot, machine, index + 1, parent, link.name, place, (0.0, 0.0, 0.0), (0, 0, 1))
        parent, place = link.name, root
    ElementTree.SubElement(robot, "link", name="tip")
    end = ElementTree.SubElement(robot, "joint", name="tip_mount", type="fixed")
    ElementTree.SubElement(end, "parent", link=parent)
    ElementTree.SubElement(end, "child", link="tip")
    ElementTree.SubElement(end, "origin", xyz=_numbers(place), rpy="0 0 0")
    ElementTree.indent(robot)
    return f'<?xml version="1.0"?>\n{ElementTree.tostring(robot, "unicode")}\n'


def _joint(
    robot: ElementTree.Element,
    machine: Machine,
    number: int,
    parent: str,
    child: str,
    place: Array,
    turn: tuple[float, float, float],
    axis: tuple[int, int, int],
) -> None:
    drive = machine.drives[number]
    joint = ElementTree.SubElement(robot, "joint", name=f"joint{number + 1}", type="revolute")
    ElementTree.SubElement(joint, "parent", link=parent)
    ElementTree.SubElement(joint, "child", link=child)
    ElementTree.SubElement(joint, "origin", xyz=_numbers(place), rpy=_numbers(turn))
    ElementTree.SubElement(joint, "axis", xyz=_numbers(axis))
    lower, upper = map(_number, drive.range)
    limit = {"lower": lower, "upper": upper, "effort": STRONGEST, "velocity": _number(drive.max_speed)}
    ElementTree.SubElement(joint, "limit", limit)
    ElementTree.SubElement(joint, "dynamics", damping=_number(drive.viscous_friction), friction="0")


def _inertial(link: ElementTree.Element, mass: float, center: Array, tensor: Array) -> None:
    inertial = ElementTree.SubElement(link, "inertial")
    ElementTree.SubElement(inertial, "origin", xyz=_numbers(center), rpy="0 0 0")
    ElementTree.SubElement(inertial, "mass", value=_number(mass))
    entries = {f"i{'xyz'[i]}{'xyz'[j]}": _number(tensor[i, j]) for i in range(3) for j in range(i, 3)}
    ElementTree.SubElement(inertial, "inertia", entries)


def _number(value: float) -> str:
    return f"{value + 0.0:.9g}"


def _numbers(values: object) -> str:
    return " ".join(map(_number, np.asarray(values, float)))
