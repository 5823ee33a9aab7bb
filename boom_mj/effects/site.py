"""Where effects may be: a place of a machine with what is known of it, and the sites of every boom."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

Location = Mapping[str, int | str]
"""A place by key, such as {"link": 3, "axis": "w"}."""


@dataclass(frozen=True)
class Site:
    """A place of a machine. Sites are equal where their locations are.

    Attributes:
        key: the location, such as (("link", 3), ("axis", "w")); () is the machine as a whole.
        tags: what effects ask of it, such as "boom", "cylinder", "measured", "driving".
        unit: of the channel, or of the joint's coordinate (rad or m).
        value: root mean square of what is commanded or logged there, or of the joint's force.
        span: of the joint's coordinate.
        speed: root mean square of the joint's speed.
        inertia, damping, stiffness, armature, friction: of the joint in the nominal model.
        mass: of the body.
        step: between samples, s.
    """

    key: tuple[tuple[str, int | str], ...] = ()
    tags: frozenset[str] = field(default=frozenset(), compare=False)
    unit: str = field(default="", compare=False)
    value: float = field(default=1.0, compare=False)
    span: float = field(default=1.0, compare=False)
    speed: float = field(default=1.0, compare=False)
    inertia: float = field(default=1.0, compare=False)
    damping: float = field(default=0.0, compare=False)
    stiffness: float = field(default=0.0, compare=False)
    armature: float = field(default=0.0, compare=False)
    friction: float = field(default=0.0, compare=False)
    mass: float = field(default=1.0, compare=False)
    step: float = field(default=1e-3, compare=False)

    @property
    def location(self) -> dict[str, int | str]:
        """The place by key, as answers and machine files say it."""
        return dict(self.key)

    @cached_property
    def keys(self) -> tuple[str, ...]:
        """Of the location."""
        return tuple(name for name, _ in self.key)

    @property
    def force_unit(self) -> str:
        """Of what acts on the joint's coordinate."""
        return "N" if self.unit == "m" else "N m"


LINKS, MARKERS = (2, 3, 4, 5), range(1, 13)
JOINT_TAGS = {
    1: (),
    2: ("cylinder", "clamp"),
    3: ("cylinder", "clamp", "linkage"),
    **dict.fromkeys((4, 5), ("clamp", "linkage")),
}


def _boom(*tags: str, **location: int | str) -> Site:
    return Site(tuple(location.items()), frozenset({"boom", *tags}))


BOOM_SITES: tuple[Site, ...] = (
    _boom(),
    *(_boom(*tags, joint=joint) for joint, tags in JOINT_TAGS.items()),
    *(_boom(link=link) for link in LINKS),
    *(
        _boom("elastic", *(() if axis == "torsion" else ("bending",)), link=link, axis=axis)
        for link in LINKS
        for axis in ("v", "w", "torsion")
    ),
    *(_boom(axes=axes) for axes in ("roll", "pitch", "roll+pitch")),
    *(_boom(direction=direction) for direction in ("vertical", "horizontal")),
    *(_boom(stream=stream) for stream in ("imu", "marker", "cylinder")),
    *(_boom(cylinder=cylinder) for cylinder in (2, 3)),
    *(_boom(marker=marker) for marker in MARKERS),
)
"""Joints 2 and 3 have cylinders; the linkages of joints 3 to 5 may have play; links are clamped at joints 2 to 5."""


def place(location: Location, sites: Sequence[Site]) -> Site | None:
    """The site of a location whose values read alike, None where there is none."""
    wanted = {key: str(value) for key, value in location.items()}
    return next((s for s in sites if {key: str(value) for key, value in s.key} == wanted), None)
