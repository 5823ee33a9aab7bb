"""What differs between healthy booms, all of it small."""

from collections.abc import Iterator
from dataclasses import replace
from functools import cache

import numpy as np

from boom_mj.effects import make_effect
from boom_mj.systems.system import Nuisance

STIFFNESS = {"v": 0.005, "w": 0.005, "torsion": 0.01}  # of all links
PLATES = 0.003  # of the stiffness of a single link
MASS, DAMPING = 0.003, 0.05  # of a link, of all of them
CHANGE = 0.002  # of those, for derivatives: one of 0.01 turns a vibration by half a radian until a recording ends
GAIN = 0.002  # of a pressure sensor
VISCOUS = 0.5  # of the machine file's, that may be missing or too much
ZERO_OFFSET, OFFSET_STEP = np.radians(0.6), 0.0005  # rad: prior of a joint's zero offset, step of its secant
OFFSET = "joint_zero_offset"  # never a cause
AS_BUILT = {"link_stiffness": 6.0, "link_mass": 7.0, "structural_damping": 5.0}  # times those: 3 %, 2 %, 25 %
JOINTS, LINKS, CYLINDERS = (1, 2, 3, 4, 5), (2, 3, 4, 5), (2, 3)


def individual() -> Iterator[Nuisance]:
    """The same, with prior deviations as wide as booms are built apart."""
    for one in nuisances():
        yield replace(one, deviation=one.deviation * AS_BUILT.get(one.hypothesis[0].id, 1.0))


@cache
def nuisances() -> tuple[Nuisance, ...]:
    """Zero offsets first, joint 1 first."""
    return tuple(_nuisances())


def _nuisances() -> Iterator[Nuisance]:
    for joint in JOINTS:
        offset = make_effect(OFFSET, {"joint": joint, "offset": OFFSET_STEP})
        yield Nuisance((offset,), ZERO_OFFSET / OFFSET_STEP)
    for joint in CYLINDERS:
        yield Nuisance((make_effect("viscous_friction", {"joint": joint, "factor": 0.0}),), VISCOUS, slow=True)
    for cylinder in CYLINDERS:
        reading = make_effect("pressure_scale", {"cylinder": cylinder, "factor": 1 + CHANGE})
        yield Nuisance((reading,), GAIN / CHANGE, slow=True)
    for axis, deviation in STIFFNESS.items():
        softer = [make_effect("link_stiffness", {"link": k, "axis": axis, "factor": 1 - CHANGE}) for k in LINKS]
        yield Nuisance(tuple(softer), deviation / CHANGE)
    for link in LINKS:
        places = [{"link": link, "axis": axis} for axis in STIFFNESS]
        thinner = [make_effect("link_stiffness", {**place, "factor": 1 - CHANGE}) for place in places]
        yield Nuisance(tuple(thinner), PLATES / CHANGE)
        yield Nuisance((make_effect("link_mass", {"link": link, "factor": 1 + CHANGE}),), MASS / CHANGE)
    yield Nuisance((make_effect("structural_damping", {"factor": 1 + CHANGE}),), DAMPING / CHANGE)
