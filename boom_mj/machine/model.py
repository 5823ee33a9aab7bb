"""What the machine is: the TOML file as validated, frozen data.

Attributes carry the names of the file. SI units; angles of the file are in degrees and end in `_deg`, the
properties beside them are in radians. A `Pair` is (root, tip); what lies between is linear in x (eq. 29, 30).
"""

import math
from collections.abc import Mapping
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any, Literal, Protocol, Self, TypeVar, get_args

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, FiniteFloat, ValidationError, model_validator

from boom_mj.errors import MachineFileError, shown
from boom_mj.files import parse_toml, read_text
from boom_mj.machine.fields import Frozen, NonNegative, Number, Pair, Point2, Positive
from boom_mj.machine.rig import Camera, Targets


def _ordered(pair: tuple[float, float]) -> tuple[float, float]:
    if pair[0] >= pair[1]:
        raise ValueError("the lower limit must lie below the upper one")
    return pair


MODELS = tuple(folder / "models" for folder in Path(__file__).parents[1:3])  # of the wheel, of the repository
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


class Rod(Frozen):
    x: Number
    y: Number


class _Bore(Frozen):
    bore: Positive
    rod_diameter: Positive

    @model_validator(mode="after")
    def _rod_fits(self) -> Self:
        if self.rod_diameter >= self.bore:
            raise ValueError(f"rod_diameter = {self.rod_diameter}: must be below the bore, {self.bore} m")
        return self


class Cylinder2(_Bore):
    """Two-point cylinder from the turret to link 2, in the joint-2 frame that turns with the slewing gear only."""

    base: Point2
    rod: Rod


class Lever(Frozen):
    length: Positive
    angle_deg: Number


class Cylinder3(_Bore):
    """Cylinder on link 2 acting through rocker and coupler on link 3; origin at joint 3, x along link 2 outward."""

    base: Point2
    rocker_pivot: Point2
    rocker_length: Positive
    coupler_length: Positive
    lever: Lever
    branch: Literal[-1, 1]


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
    effect: tuple[EffectEntry, ...] = ()
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


Kind = TypeVar("Kind", bound=Frozen)


def machine_file(name: Path | str) -> Path:
    """The file of a machine that comes with the package, by a name such as "boom36"; any other path as it is."""
    shipped = (folder / f"{name}.toml" for folder in MODELS if not Path(name).suffix)
    return next((path for path in shipped if path.is_file()), Path(name))


def load_machine(path: Path | str) -> Machine:
    """Read the machine file of a boom, or one that comes with the package by its name.

    Raises:
        MachineFileError: the file is missing, is no TOML, or holds bad values; every one of them is listed with its
            place, the value and what is allowed.
    """
    return parse_machine(read_text(machine_file(path), MachineFileError), str(path))


def parse_machine(text: str, source: str = "machine file") -> Machine:
    """The boom that a TOML text describes; see `load_machine`."""
    return parse(Machine, text, source)


def parse(kind: type[Kind], text: str, source: str) -> Kind:
    """A machine of some kind from a TOML text; see `load_machine`."""
    content = parse_toml(text, source, MachineFileError)
    try:
        return kind.model_validate(content)
    except ValidationError as error:
        raise MachineFileError("\n".join(f"{source}: {line}" for line in _sentences(kind, error))) from error


def with_values(machine: Machine, values: Mapping[str, float]) -> Machine:
    """The machine with other numbers at places of its file: "link3.mass", "damping.bending", "link2.wall.0".

    Raises:
        MachineFileError: there is no such number, with what there is; or a value that is not allowed.
    """
    content: dict[str, Any] = machine.model_dump(mode="json")
    content |= {link["name"]: link for link in content.pop("link")}
    for place, value in values.items():
        node: Any = content
        parts = place.split(".")
        for k, part in enumerate(parts):
            keys = {str(key): key for key in (range(len(node)) if isinstance(node, list) else node)}
            if part not in keys or isinstance(node[keys[part]], dict | list) != (k + 1 < len(parts)):
                within = f"in {'.'.join(parts[:k])}" if k else "at its top"
                raise MachineFileError(f"the machine file has no number {place}; {within} there are {', '.join(keys)}")
            holder, key, node = node, keys[part], node[keys[part]]
        if not isinstance(node, int | float):
            raise MachineFileError(f"the machine file has no number {place}: it is {node!r}")
        holder[key] = value
    content["link"] = [content.pop(link.name) for link in machine.link]
    try:
        return Machine.model_validate(content)
    except ValidationError as error:
        raise MachineFileError("; ".join(_sentences(Machine, error))) from error


def _sentences(machine: type[Frozen], error: ValidationError) -> list[str]:
    """One line per bad value: its place, the value, what is allowed; of a machine of another kind, that alone."""
    lines, errors = [], error.errors()
    for item in [item for item in errors if item["loc"] == ("kind",)] or errors:
        place, kind, value = _place(machine, item["loc"]), item["type"], item["input"]
        if kind == "missing":
            lines.append(f"{place} is missing")
        elif kind == "extra_forbidden":
            known = ", ".join(_known(machine, item["loc"][:-1]))
            lines.append(f"{place} = {shown(value)}: unknown key; known here: {known}")
        elif kind == "value_error":
            message = item["msg"].removeprefix("Value error, ")
            after = "" if isinstance(value, dict) else f" = {shown(value)}"
            lines.append(f"{place}{after}: {message}" if place else message)
        else:
            lines.append(f"{place} = {shown(value)}: {item['msg'][0].lower()}{item['msg'][1:]}")
    return lines


def _place(machine: type[Frozen], location: tuple[int | str, ...]) -> str:
    """Where in the file, as its reader would say it: link3.wall.1 of a boom rather than link.1.wall.1."""
    match location:
        case ("link", int(index), *rest) if machine is Machine:
            location = (f"link{index + 2}", *rest)
    return ".".join(str(part) for part in location)


def _known(machine: type[Frozen], location: tuple[int | str, ...]) -> list[str]:
    """The keys that the machine file knows at a place."""
    model: type[BaseModel] = machine
    for part in location:
        if isinstance(part, str):
            annotation = model.model_fields[part].annotation
            kinds = (annotation, *get_args(annotation))
            model = next(kind for kind in kinds if isinstance(kind, type) and issubclass(kind, BaseModel))
    return sorted(model.model_fields)
