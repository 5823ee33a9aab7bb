"""The boom from the side: joints, links, markers and cylinders in the vertical plane of the boom, without bending."""

from dataclasses import dataclass

import numpy as np

from boom_mj.machine import Machine

Array = np.ndarray
THICK = 1.8  # times its height a link is drawn


@dataclass(frozen=True)
class Side:
    """A pose in the plane of the boom: x outward from the slewing axis, z up, m.

    Attributes:
        joints: joints 2 to 5 and the tip, (5, 2).
        angles: of links 2 to 5 against the horizontal, (4,), rad.
        outlines: per link a polygon, (4, 2).
        markers: (m, 2), root outward.
        cylinders: ends of cylinders 2 and 3, (2, 2) each; the rocker of cylinder 3 is left out.
    """

    joints: Array
    angles: Array
    outlines: tuple[Array, ...]
    markers: Array
    cylinders: tuple[Array, Array]


def side_view(machine: Machine, joints: Array) -> Side:
    """The boom at joint angles q1..q5, (5,), rad."""
    angles = np.cumsum(joints[1:])
    lengths = np.array([link.length for link in machine.links])
    steps = lengths[:, None] * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    base = np.array([0.0, machine.slewing.pivot_height])
    points = base + np.vstack([np.zeros(2), np.cumsum(steps, axis=0)])

    def on_link(k: int, along: float, up: float) -> Array:
        """World place of a point of link k + 2, `along` from its root and `up` from its axis, m."""
        turn = np.array([[np.cos(angles[k]), -np.sin(angles[k])], [np.sin(angles[k]), np.cos(angles[k])]])
        return points[k] + turn @ np.array([along, up])

    outlines = []
    for k, link in enumerate(machine.links):
        root, tip = (THICK * height / 2 for height in link.height)
        corners = ((0, -root), (link.length, -tip), (link.length, tip), (0, root))
        outlines.append(np.array([on_link(k, *corner) for corner in corners]))
    places = [(k, link.length * (1 + x)) for k, link in enumerate(machine.links) for x in machine.sensors.markers_x]
    second, third = machine.cylinder2, machine.cylinder3
    lever = np.radians(third.lever.angle_deg)
    cylinders = (
        np.array([base + second.base, on_link(0, lengths[0] + second.rod.x, second.rod.y)]),
        np.array(
            [
                on_link(0, lengths[0] + third.base[0], third.base[1]),
                on_link(1, third.lever.length * np.cos(lever), third.lever.length * np.sin(lever)),
            ]
        ),
    )
    markers = np.array([on_link(k, along, 0.0) for k, along in places])
    return Side(points, angles, tuple(outlines), markers, cylinders)


def place_of(side: Side, location: dict[str, int | str]) -> Array | None:
    """Where an effect's location is, (2,), m; None where it is no place on the boom."""
    match location:
        case {"joint": 1}:
            return side.joints[0] - np.array([0.0, 1.4])
        case {"joint": int(k)}:
            return side.joints[k - 2]
        case {"link": int(k)}:
            return (side.joints[k - 2] + side.joints[k - 1]) / 2
        case {"cylinder": int(k)}:
            return side.cylinders[k - 2].mean(axis=0)
        case {"marker": int(k)} if k <= len(side.markers):
            return side.markers[k - 1]
    return None
