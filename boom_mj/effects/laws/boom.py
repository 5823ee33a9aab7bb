"""Laws of booms."""

from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import replace
from typing import Any, ClassVar

import mujoco
import numpy as np

from boom_mj.effects.base import Array
from boom_mj.effects.kinds import AngleEffect, ForceEffect, ModelEffect, Motion, OutputEffect
from boom_mj.effects.laws.law import Law
from boom_mj.effects.spec_edits import BASE_AXES, add_point_mass, bent_by, link_hinges, spring_base, tilt_base
from boom_mj.machine import Machine, cylinder_lengths
from boom_mj.recording import Signal

FAR = 10.0  # rad, where no hinge ever is
BALL, THIN = 1e-3, 1e-6  # m, radius of what feels the fluid, and kg/m^3, its density
AXES = "xyz"


class CylinderLaw(Law, OutputEffect):
    """What a cylinder's force has besides: the motion does not change, the pressure sensor reads it.

    `position` is the cylinder's length, `load` its force without the law, `angle` that of its joint.
    """

    at = ("cylinder",)
    needs = frozenset({"boom"})
    variables = {"position": "m", "speed": "m/s", "load": "N", "angle": "rad", "time": "s"}
    unit = "N"

    def observe(self, signals: Mapping[str, Signal], machine: Machine) -> Mapping[str, Signal]:
        if self.silent:
            return {}
        column = int(self.location["cylinder"]) - 2
        force = signals["cylinder/force"]
        values = force.values.copy()
        values[:, column] += self.law(**cylinder_variables(signals, machine, column), **self.values)
        return {"cylinder/force": replace(force, values=values)}

    @abstractmethod
    def law(self, **variables: Any) -> Array:
        """Force, (n,), N."""


def cylinder_variables(signals: Mapping[str, Signal], machine: Machine, column: int) -> dict[str, Array]:
    """Of cylinder 2 (column 0) or 3, at the times of its force; see `CylinderLaw`."""
    joints, force = signals["joint/position"], signals["cylinder/force"]
    length = np.interp(force.time, joints.time, cylinder_lengths(machine, joints.values)[:, column])
    angle = np.interp(force.time, joints.time, joints.values[:, column + 1])
    load, time = force.values[:, column], force.time
    return {"position": length, "speed": np.gradient(length, time), "load": load, "angle": angle, "time": time}


class AxisLaw(Law, OutputEffect):
    """What one axis of a sensor of a boom reads besides; `angle` is that of the joint that turns it.

    Attributes:
        axis: x, y or z.
    """

    needs = frozenset({"boom"})
    variables = {"reading": "", "angle": "rad", "time": "s"}
    axis: ClassVar[str] = "x"

    @property
    @abstractmethod
    def reads(self) -> tuple[str, int, int]:
        """Signal, its column, and the joint."""

    def observe(self, signals: Mapping[str, Signal], machine: Machine) -> Mapping[str, Signal]:
        if self.silent:
            return {}
        name, column, _ = self.reads
        values = signals[name].values.copy()
        values[:, column] += self.law(**axis_variables(signals, *self.reads), **self.values)
        return {name: replace(signals[name], values=values)}

    @abstractmethod
    def law(self, **variables: Any) -> Array:
        """What it reads too much, (n,), in its unit."""


def axis_variables(signals: Mapping[str, Signal], name: str, column: int, joint: int) -> dict[str, Array]:
    """Of a column of a sensor that a joint turns; see `AxisLaw`."""
    joints, own = signals["joint/position"], signals[name]
    angle = np.interp(own.time, joints.time, joints.values[:, joint - 1])
    return {"reading": own.values[:, column], "angle": angle, "time": own.time}


class ImuLaw(AxisLaw):
    """What one axis of an IMU reads besides, m/s^2 or rad/s.

    Attributes:
        sensor: "specific_force" or "angular_rate".
    """

    at = ("link",)
    sensor: ClassVar[str] = "specific_force"

    @property
    def reads(self) -> tuple[str, int, int]:
        link = int(self.location["link"])
        return f"imu/link{link}/{self.sensor}", AXES.index(self.axis), link


class MarkerLaw(AxisLaw):
    """What one coordinate of a marker, in the world frame, is read to be besides, m; `angle` is the slewing one."""

    at = ("marker",)

    @property
    def reads(self) -> tuple[str, int, int]:
        return "markers", 3 * int(self.location["marker"]) - 3 + AXES.index(self.axis), 1


class AngleLaw(Law, AngleEffect):
    """What a joint's angle sensor reads besides."""

    variables = {"angle": "rad"}
    unit = "rad"

    def error(self, angle: Array) -> Array:
        return np.zeros_like(angle) if self.silent else self.law(angle=angle, **self.values)

    @abstractmethod
    def law(self, **variables: Any) -> Array:
        """Reading less true angle, (n,), rad."""


class LinkLaw(Law, ModelEffect):
    """How a link resists bending: M = E I k (1 + linear + square k + cube k^2), and a stop.

    k is its curvature less the one at which it rests, `offset`.
    The stop is a spring over the slope that the whole link gathers, beyond `stop` towards positive angles. Its table
    holds `linear`, `offset` (1/m), `square` (m), `cube` (m^2), or `stop_stiffness` (N m/rad) and `stop` (rad).

    Attributes:
        bends: v or w.
    """

    at = ("link",)
    needs = frozenset({"boom"})
    variables = {"curvature": "1/m", "slope": "rad"}
    unit = "N m"
    bends: ClassVar[str] = "v"

    def edit(self, spec: mujoco.MjSpec, machine: Machine) -> None:
        if self.silent:
            return
        link, values = int(self.location["link"]), self.values
        for hinge, length in bent_by(spec, machine, link, self.bends):
            linear, square, cube = hinge.stiffness
            square = square + linear * values.get("square", 0.0) / length
            cube = cube + linear * values.get("cube", 0.0) / length**2
            hinge.stiffness = [linear * (1 + values.get("linear", 0.0)), square, cube]
            hinge.springref += values.get("offset", 0.0) * length
        if stiffness := values.get("stop_stiffness"):
            stop = spec.add_tendon(name=f"stop_link{link}_{self.bends}")
            for hinge in link_hinges(spec, link, self.bends):
                stop.wrap_joint(hinge.name, 1.0)
            stop.springlength, stop.stiffness[0] = [-FAR, values["stop"]], stiffness


class TipLaw(Law, ModelEffect, ForceEffect):
    """A force on the tip: a constant one downwards, inertia, and drag against its velocity, c |v| v.

    Its table holds any of `weight` (N), `inertia` (kg, not negative) and `drag` (N s^2/m^2). What has inertia and no
    weight is a body whose gravity is compensated. MuJoCo's drag of an ellipsoid in a fluid is the drag: rho C A = c, so
    thin that the boom's own surfaces feel nothing of it. Springs and dampers move as with the implicit integrator, to
    the last digit; that one would derive the fluid's force on every body, which takes four times as long and, by a
    tip that jolts, errs by four times as much.
    """

    needs = frozenset({"boom"})
    variables = {"velocity": "m/s", "acceleration": "m/s^2"}
    unit = "N"

    def point(self, machine: Machine) -> str:
        """Name of the site on which it acts."""
        return "tip"

    def edit(self, spec: mujoco.MjSpec, machine: Machine) -> None:
        point = spec.site(self.point(machine))
        if (inertia := self.values.get("inertia", 0.0)) > 0:
            add_point_mass(point, f"{point.name}_inertia", inertia, gravcomp=1.0)
        if not (drag := self.values.get("drag", 0.0)):
            return
        spec.option.density = THIN
        spec.option.integrator = mujoco.mjtIntegrator.mjINT_EULER  # see above
        ball = point.parent.add_geom(type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[BALL, 0, 0], pos=point.pos)
        ball.mass, ball.contype, ball.conaffinity, ball.fluid_ellipsoid = 0.0, 0, 0, 1.0
        ball.fluid_coefs = [drag / (THIN * np.pi * BALL**2), 0.0, 0.0, 0.0, 0.0]

    def force(self, motion: Motion) -> Mapping[str, Array]:
        down = np.tile([0.0, 0.0, -self.values.get("weight", 0.0)], (len(motion.time), 1))
        return {self.point(motion.boom): down} if self.values.get("weight") else {}


class MiddleLaw(TipLaw):
    """The same on the middle of a link, where its middle marker is."""

    at = ("link",)

    def point(self, machine: Machine) -> str:
        return machine.middle_marker(int(self.location["link"]))


class BaseLaw(Law, ModelEffect):
    """How a boom stands: aslant, as `base_tilt` has it, and on springs at the origin that give more or less.

    Its table holds any of `roll_tilt`, `pitch_tilt` (rad), `roll_give`, `pitch_give` (rad/(N m), not negative) and, of
    what gives, `roll_hardness`, `pitch_hardness` (1/rad^2): angle (1 + hardness angle^2) = give moment.
    """

    at = ("axes",)
    needs = frozenset({"boom"})
    variables = {"moment": "N m", "angle": "rad"}
    unit = "rad"

    def edit(self, spec: mujoco.MjSpec, machine: Machine) -> None:
        values = self.values
        if any(tilt := [values.get(f"{axis}_tilt", 0.0) for axis in BASE_AXES]):
            tilt_base(spec, *tilt)
        for axis in BASE_AXES:
            if (give := values.get(f"{axis}_give", 0.0)) > 0:
                spring = spring_base(spec, machine, axis, 1 / give)
                spring.stiffness[2] = values.get(f"{axis}_hardness", 0.0) * spring.stiffness[0]
