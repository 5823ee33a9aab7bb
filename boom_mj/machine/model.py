"""What the machine is: the TOML file as validated, frozen data.

Attributes carry the names of the file. SI units; angles of the file are in degrees and end in `_deg`, the
properties beside them are in radians. A `Pair` is (root, tip); what lies between is linear in x (eq. 29, 30).
"""

import math
from functools import cached_property
from typing import Annotated, Literal, Protocol, Self

from pydantic import AfterValidator, BeforeValidator, ConfigDict, Field, FiniteFloat, model_validator

from boom_mj.machine.cylinders import Cylinder2, Cylinder3
from boom_mj.machine.fields import Frozen, NonNegative, Number, Pair, Positive
from boom_mj.machine.rig import Camera, Targets


def _ordered(pair: tuple[float, float]) -> tuple[float, float]:
    if pair[0] >= pair[1]:
        raise ValueError("the lower limit must lie below the upper one")
    return pair


RangeDeg = Annotated[tuple[Number, Number], AfterValidator(_ordered)]


class Drive(Frozen):
    """What every joint has: limits, speed limit and viscous friction (eq. 24)."""

    range_deg: RangeDeg
    max_speed_deg_s: Positive
    viscous_friction: NonNegative
    """N m s/rad"""

    @property
    def range(self) -> tuple[float, float]:
        """Joint limits, rad."""
        return math.radians(self.range_deg[0]), math.radians(self.range_deg[1])

    @property
    def max_speed(self) -> float:
        """rad/s"""
        return math.radians(self.max_speed_deg_s)


class Slewing(Drive):
    """Joint 1: turns about the vertical axis; `pivot_height` is the joint-2 axis above ground, m."""

    pivot_height: Positive


class ElasticLink(Frozen):
    """What bends: a tapered box from its root at x = -length to its tip at x = 0, solid where walls meet."""

    name: str
    length: Positive
    mass: Positive
    center_of_gravity: Number
    height: Pair
    width: Pair
    wall: Pair
    rotary_inertia: Pair
    offset: Number
    youngs_modulus_y: Positive
    youngs_modulus_z: Positive
    shear_modulus: Positive
    support: Number | None = None

    @property
    def line_mass(self) -> tuple[float, float]:
        """Line mass density (root, tip) in kg/m that meets mass (34) and centre of gravity (35)."""
        m, c, l = self.mass, self.center_of_gravity, self.length
        return -6 * m * c / l**2 - 2 * m / l, 4 * m / l + 6 * m * c / l**2

    @model_validator(mode="after")
    def _is_a_box(self) -> Self:
        low, high = -2 / 3 * self.length, -self.length / 2
        if not low < self.center_of_gravity <= high:
            raise ValueError(
                f"center_of_gravity = {self.center_of_gravity}: a linear line mass that is positive everywhere and not "
                f"heavier at the tip than at the root needs a value in ({low:.4g}, {high:.4g}] m"
            )
        for side, (height, width, wall) in zip(("root", "tip"), zip(self.height, self.width, self.wall)):
            if 2 * wall > min(height, width):
                raise ValueError(
                    f"wall = {wall} at the {side}: must be at most half the box, {min(height, width) / 2} m"
                )
        area = [2 * t * (h + w - 2 * t) for h, w, t in zip(self.height, self.width, self.wall)]
        if area[1] > area[0]:
            raise ValueError(
                f"height, width, wall: the section at the tip ({area[1]:.3g} m^2) must not be heavier than the one "
                f"at the root ({area[0]:.3g} m^2)"
            )
        if self.support is not None and not -self.length < self.support < 0:
            raise ValueError(f"support = {self.support}: must lie on the link, between {-self.length} and 0 m")
        return self


class Link(Drive, ElasticLink):
    """One link of a boom, with the joint at its root."""


class OffsetProfile(Frozen):
    kind: Literal["ramp", "step"]


class Damping(Frozen):
    """Kelvin-Voigt `relaxation_time` (s) and the line dissipations d_v = d_w = `bending`, d_t = `torsion` of (24)."""

    relaxation_time: NonNegative
    bending: NonNegative
    torsion: NonNegative


class MassAt(Frozen):
    mass: NonNegative
    x: Number


class PointMasses(Frozen):
    """Actuator masses of eq. (20): at the tips of links 2-4 and at two places of link 2."""

    joint3: NonNegative
    joint4: NonNegative
    joint5: NonNegative
    cylinder2: MassAt
    cylinder3: MassAt


class EndHose(Frozen):
    length: Positive
    empty_mass: NonNegative


class DeliveryPipe(Frozen):
    mass_per_length_concrete: NonNegative


class Rates(Frozen):
    joint: Positive
    imu: Positive
    marker: Positive
    cylinder: Positive


class Noise(Frozen):
    """Standard deviations: deg, m/s^2, rad/s, m (world x and z), m (world y), N."""

    joint_deg: NonNegative
    accelerometer: NonNegative
    gyroscope: NonNegative
    marker_xz: NonNegative
    marker_y: NonNegative
    cylinder_force: NonNegative


class EffectEntry(Frozen):
    """An effect that this machine has beyond the nominal model: its id, and its place and parameters by name."""

    model_config = ConfigDict(frozen=True, extra="allow")

    id: str


def _at_one_joint(entries: object) -> object:
    """Zero offsets of files of version 0.1, `joint1 = 0.002` of all joints in one entry, as one entry each."""
    if not isinstance(entries, list | tuple):
        return entries
    found = []
    for entry in entries:
        joints = {f"joint{k}": k for k in range(1, 6)}
        if isinstance(entry, dict) and entry.get("id") == "joint_zero_offset" and joints.keys() & entry.keys():
            rest = {key: value for key, value in entry.items() if key not in joints}
            found += [{**rest, "joint": k, "offset": entry[key]} for key, k in joints.items() if key in entry]
        else:
            found.append(entry)
    return found


class Sensors(Frozen):
    rates_hz: Rates
    noise: Noise
    markers_x: tuple[Annotated[FiniteFloat, Field(ge=-1, le=0)], ...]
    """Marker places as fractions of the link length, root outward."""


class Elastic(Protocol):
    """What shapes and hinges need to know of a machine: elastic links in a row, their loads and damping."""

    @property
    def gravity(self) -> float:
        """m/s^2."""

    @property
    def links(self) -> tuple[ElasticLink, ...]:
        """Root outward."""

    @property
    def offset_profile(self) -> OffsetProfile:
        """How links are offset from their drives."""

    @property
    def damping(self) -> Damping:
        """Of all links."""

    @property
    def masses_on_link(self) -> tuple[tuple[tuple[float, float], ...], ...]:
        """Per link its point masses as (x in m, mass in kg)."""

    def __hash__(self) -> int: ...


class Machine(Frozen):
    """A large manipulator: slewing gear and a planar chain of elastic links."""

    kind: Literal["boom"] = "boom"
    name: str
    gravity: NonNegative
    slewing: Slewing
    link: tuple[Link, Link, Link, Link]
    offset_profile: OffsetProfile
    damping: Damping
    point_masses: PointMasses
    cylinder2: Cylinder2
    cylinder3: Cylinder3
    end_hose: EndHose
    delivery_pipe: DeliveryPipe
    sensors: Sensors
    effect: Annotated[tuple[EffectEntry, ...], BeforeValidator(_at_one_joint)] = ()
    camera: tuple[Camera, ...] = ()
    targets: Targets = Targets()

    @property
    def links(self) -> tuple[Link, ...]:
        """Links 2 to 5, root outward."""
        return self.link

    @property
    def drives(self) -> tuple[Drive, ...]:
        """Joints 1 to 5."""
        return (self.slewing, *self.link)

    @cached_property
    def masses_on_link(self) -> tuple[tuple[tuple[float, float], ...], ...]:
        """Per link the point masses of eq. (20) as (x in m, mass in kg)."""
        p = self.point_masses
        second = ((p.cylinder2.x, p.cylinder2.mass), (p.cylinder3.x, p.cylinder3.mass), (0.0, p.joint3))
        return second, ((0.0, p.joint4),), ((0.0, p.joint5),), ()

    def middle_marker(self, link: int) -> str:
        """Name of the marker in the middle of those of a link."""
        each = len(self.sensors.markers_x)
        return f"marker{each * (link - 2) + each // 2 + 1}"

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        for index, link in enumerate(self.link):
            if link.name != f"link{index + 2}":
                raise ValueError(
                    f"{link.name!r} stands where 'link{index + 2}' belongs: links come in order, root outward"
                )
            if (link.support is not None) != (index == 0):
                raise ValueError(
                    f"{link.name}.support = {link.support}: link2 has a cylinder support, no other link has one"
                )
        if len({camera.name for camera in self.camera}) < len(self.camera):
            raise ValueError(f"camera: names must differ; got {', '.join(camera.name for camera in self.camera)}")
        for place in ("cylinder2", "cylinder3"):
            x = getattr(self.point_masses, place).x
            if not -self.link[0].length <= x <= 0:
                raise ValueError(
                    f"point_masses.{place}.x = {x}: must lie on link2, between {-self.link[0].length} and 0 m"
                )
        return self
