"""Cylinders of the machine's file, and the rocker and coupler that carry one's force to its joint."""

from typing import Literal, Self

from pydantic import model_validator

from boom_mj.machine.fields import Frozen, Number, Point2, Positive


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
