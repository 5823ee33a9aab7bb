"""Laws: effects whose physics is a formula at one place, such as `gap discover` finds and people write.

A law is a subclass of one of these with an id, a table and a method `law`, whose arguments are the variables of the
place - arrays (n,) by name - and the parameters. It vanishes where all parameters that are neutral at 0 are 0.
"""

from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import replace
from typing import Any, ClassVar

import mujoco
import numpy as np

from boom_mj.effects.base import Array, Effect
from boom_mj.effects.filters import fading as fading
from boom_mj.effects.filters import lagged as lagged
from boom_mj.effects.kinds import (
    INVERSIONS,
    ActuatorEffect,
    AngleEffect,
    ChannelEffect,
    ForceEffect,
    ModelEffect,
    Motion,
    OutputEffect,
)
from boom_mj.effects.spec_edits import BASE_AXES, add_tip_mass, bent_by, link_hinges, spring_base, tilt_base
from boom_mj.machine import Machine, cylinder_lengths
from boom_mj.recording import Signal

FAR = 10.0  # rad, where no hinge ever is
BALL, THIN = 1e-3, 1e-6  # m, radius of what feels the fluid, and kg/m^3, its density
AXES = "xyz"


def direction(speed: Array, creep: float) -> Array:
    """The sign of a speed, which it changes smoothly over a small one: dry friction over its force, (n,)."""
    return np.tanh(speed / creep)


class Law(Effect):
    """Common to all laws.

    Attributes:
        formula: for people.
        variables: arguments of `law` by name, with their units.
        unit: of what `law` gives.
    """

    formula: ClassVar[str] = ""
    variables: ClassVar[Mapping[str, str]] = {}
    unit: ClassVar[str] = ""

    @property
    def silent(self) -> bool:
        """Whether it does nothing."""
        return not any(self.values[name] for name, p in self.declared.items() if p.neutral == 0)


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


class ImuLaw(Law, OutputEffect):
    """What one axis of an IMU reads besides; `angle` is that of the joint that turns its link.

    Attributes:
        sensor: "specific_force" or "angular_rate".
        axis: x, y or z.
    """

    at = ("link",)
    needs = frozenset({"boom"})
    variables = {"reading": "m/s^2", "angle": "rad", "time": "s"}
    sensor: ClassVar[str] = "specific_force"
    axis: ClassVar[str] = "x"

    def observe(self, signals: Mapping[str, Signal], machine: Machine) -> Mapping[str, Signal]:
        if self.silent:
            return {}
        name, column = f"imu/link{self.location['link']}/{self.sensor}", AXES.index(self.axis)
        values = signals[name].values.copy()
        variables = imu_variables(signals, int(self.location["link"]), self.sensor, column)
        values[:, column] += self.law(**variables, **self.values)
        return {name: replace(signals[name], values=values)}

    @abstractmethod
    def law(self, **variables: Any) -> Array:
        """What it reads too much, (n,), in its unit."""


def imu_variables(signals: Mapping[str, Signal], link: int, sensor: str, column: int) -> dict[str, Array]:
    """Of an axis of an IMU; see `ImuLaw`."""
    joints, own = signals["joint/position"], signals[f"imu/link{link}/{sensor}"]
    angle = np.interp(own.time, joints.time, joints.values[:, link - 1])
    return {"reading": own.values[:, column], "angle": angle, "time": own.time}


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
    """A force on the tip: a constant one downwards, inertia, and drag against the tip's velocity, c |v| v.

    Its table holds any of `weight` (N), `inertia` (kg, not negative) and `drag` (N s^2/m^2). What has inertia and no
    weight is a body whose gravity is compensated. MuJoCo's drag of an ellipsoid in a fluid is the drag: rho C A = c, so
    thin that the boom's own surfaces feel nothing of it. Springs and dampers move as with the implicit integrator, to
    the last digit; that one would derive the fluid's force on every body, which takes four times as long and, by a
    tip that jolts, errs by four times as much.
    """

    needs = frozenset({"boom"})
    variables = {"velocity": "m/s", "acceleration": "m/s^2"}
    unit = "N"

    def edit(self, spec: mujoco.MjSpec, machine: Machine) -> None:
        if (inertia := self.values.get("inertia", 0.0)) > 0:
            add_tip_mass(spec, "inertia", inertia, gravcomp=1.0)
        if not (drag := self.values.get("drag", 0.0)):
            return
        spec.option.density = THIN
        spec.option.integrator = mujoco.mjtIntegrator.mjINT_EULER  # see above
        tip = spec.site("tip")
        ball = tip.parent.add_geom(name="ball", type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[BALL, 0, 0], pos=tip.pos)
        ball.mass, ball.contype, ball.conaffinity, ball.fluid_ellipsoid = 0.0, 0, 0, 1.0
        ball.fluid_coefs = [drag / (THIN * np.pi * BALL**2), 0.0, 0.0, 0.0, 0.0]

    def force(self, motion: Motion) -> Mapping[str, Array]:
        down = np.tile([0.0, 0.0, -self.values.get("weight", 0.0)], (len(motion.time), 1))
        return {"tip": down} if self.values.get("weight") else {}


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


class JointLaw(Law, ForceEffect):
    """What resists the motion of a joint of any MJCF machine; `load` is what its actuator exerts without it."""

    at = ("joint",)
    needs = frozenset({"mjcf", "measured"})
    variables = {"position": "", "speed": "", "load": "", "time": "s"}

    def force(self, motion: Motion) -> Mapping[str, Array]:
        joint = str(self.location["joint"])
        variables = {"position": motion.position[joint], "speed": motion.speed[joint], "load": motion.load[joint]}
        return {joint: -self.law(**variables, time=motion.time, **self.values)}

    @abstractmethod
    def law(self, **variables: Any) -> Array:
        """Resisting force, (n,), N or N m, positive against positive speed."""


class ActuatorLaw(Law, ActuatorEffect):
    """What an actuator of any MJCF machine makes of its command besides the command itself."""

    variables = {"command": "", "time": "s"}

    def apply(self, time: Array, true: Array) -> Array:
        return true if self.silent else true + self.law(command=true, time=time, **self.values)

    def invert(self, time: Array, read: Array) -> Array:
        true = read
        for _ in range(0 if self.silent else INVERSIONS):
            true = read - self.law(command=true, time=time, **self.values)
        return true

    @abstractmethod
    def law(self, **variables: Any) -> Array:
        """What is done less what is commanded, (n,)."""


class ChannelLaw(Law, ChannelEffect):
    """What a compared channel of any MJCF machine reads besides."""

    needs = frozenset({"mjcf", "compared"})
    variables = {"reading": "", "time": "s"}

    def apply(self, time: Array, true: Array) -> Array:
        return true if self.silent else true + self.law(reading=true, time=time, **self.values)

    def invert(self, time: Array, read: Array) -> Array:
        return read if self.silent else read - self.law(reading=read, time=time, **self.values)

    @abstractmethod
    def law(self, **variables: Any) -> Array:
        """What it reads too much, (n,), in its unit."""
