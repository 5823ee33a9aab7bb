"""A beam: one elastic link, clamped at its root, that bends in the plane of its height."""

import math
from typing import Literal, Self

from pydantic import model_validator

from boom_mj.machine.fields import Frozen, NonNegative, Point3
from boom_mj.machine.model import Damping, ElasticLink, OffsetProfile


class Clamp(Frozen):
    """Where the root is, and where the link points from there, world; `up` is the direction of its height."""

    position: Point3 = (0.0, 0.0, 0.0)
    along: Point3 = (1.0, 0.0, 0.0)
    up: Point3 = (0.0, 0.0, 1.0)

    @model_validator(mode="after")
    def _is_a_frame(self) -> Self:
        lengths = math.hypot(*self.along), math.hypot(*self.up), 1 + sum(a * b for a, b in zip(self.along, self.up))
        if any(abs(length - 1) > 1e-6 for length in lengths):
            raise ValueError(f"along = {self.along} and up = {self.up} must be unit vectors at a right angle")
        return self


class Marker(Frozen):
    """A point whose position is measured: x along the link from its tip, y up, z to the right, m."""

    name: str
    position: Point3


class Beam(Frozen):
    """A clamped link; gravity pulls against `clamp.up`."""

    kind: Literal["beam"]
    name: str
    gravity: NonNegative
    clamp: Clamp = Clamp()
    link: tuple[ElasticLink]
    damping: Damping = Damping(relaxation_time=0.0, bending=0.0, torsion=0.0)
    marker: tuple[Marker, ...] = ()

    @property
    def links(self) -> tuple[ElasticLink, ...]:
        """The one link there is."""
        return self.link

    @property
    def offset_profile(self) -> OffsetProfile:
        """How a link is offset from its drive: not at all."""
        return OffsetProfile(kind="step")

    @property
    def masses_on_link(self) -> tuple[tuple[tuple[float, float], ...], ...]:
        """Per link its point masses as (x in m, mass in kg): none."""
        return ((),)

    @model_validator(mode="after")
    def _is_clamped(self) -> Self:
        for name, allowed in (("support", None), ("offset", 0.0)):
            if (given := getattr(self.link[0], name)) != allowed:
                raise ValueError(f"link.{name} = {given}: a clamped link has none")
        return self
