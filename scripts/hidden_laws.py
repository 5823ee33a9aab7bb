"""Laws that are in no library, for the sealed check of `gap discover`: drawn at random, and as effects of a plant.

Forces and readings are computed here, not by the grammar: the memory by its own recursion.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, ClassVar

import mujoco
import numpy as np

from boom_mj.blind.detectability import Detectability
from boom_mj.blind.sampling import VISIBLE
from boom_mj.effects import BOOM_SITES, Effect, ForceEffect, ModelEffect, Motion, OutputEffect, Parameter
from boom_mj.effects.spec_edits import bent_by
from boom_mj.machine import Machine, cylinder_lengths
from boom_mj.recording import Signal
from boom_mj.simulation import CATALOGUE

Array = np.ndarray
TRAIN, HOLDOUT = ("fold_in", "sweep", "release_bow_vertical"), ("mixed", "release_bow_horizontal")
FORMS = ("load_friction", "ripple", "tip_drag", "hardening", "sag", "gain", "memory", "stop", "square_drag", "ground")
FORMS += ("middle_drag", "creeping_marker")
BEND = 0.02  # rad
MOMENT = 4e5  # N m, of a boom half stretched
TRIES = 12  # draws of a form
NUMBER = {"number": Parameter("1", 0.0, -1e12, 1e12, 1.0)}


class Cylinder(OutputEffect):
    """One of the forms in a cylinder's force."""

    id = "hidden_cylinder"
    at = ("cylinder",)
    table: ClassVar = NUMBER
    form: str
    sizes: Mapping[str, float]

    def observe(self, signals: Mapping[str, Signal], machine: Machine) -> Mapping[str, Signal]:
        column = int(self.location["cylinder"]) - 2
        joints, force = signals["joint/position"], signals["cylinder/force"]
        length = cylinder_lengths(machine, joints.values)[:, column]
        speed, load, s = np.gradient(length, joints.time), force.values[:, column], self.sizes
        sign = np.tanh(speed / 2e-4)
        if self.form == "load_friction":
            extra = s["mu"] * np.abs(load) * sign
        elif self.form == "ripple":
            extra = s["amplitude"] * np.sin(2 * np.pi * length / s["period"] + s["phase"])
        elif self.form == "sag":
            extra = -s["a"] * np.abs(speed) * load
        elif self.form == "gain":
            extra = s["g"] * (joints.values[:, column + 1] - s["angle"]) * load
        elif self.form == "memory":
            extra = s["force"] * decayed(joints.time, speed, s["tau"])
        elif self.form == "stop":
            extra = s["stiffness"] * np.maximum(s["side"] * (length - s["at"]), 0.0)
        else:
            extra = s["drag"] * np.abs(speed) * speed
        values = force.values.copy()
        values[:, column] += extra
        return {"cylinder/force": replace(force, values=values)}


def decayed(time: Array, speed: Array, tau: float) -> Array:
    """After a stop 1 in the direction in which it moved, falling to 1/e in tau; 0 in motion and before the first."""
    moving, out, last, since = np.abs(speed) > 2e-4, np.zeros(len(time)), 0.0, 0.0
    for k in range(len(time)):
        if moving[k]:
            last, since = np.sign(speed[k]), time[k]
        else:
            out[k] = last * np.exp(-(time[k] - since) / tau)
    return out


class ImuGain(OutputEffect):
    """The gain of an accelerometer's axis depends on the joint's angle."""

    id = "hidden_gain"
    at = ("link",)
    table: ClassVar = NUMBER
    sizes: Mapping[str, float]

    def observe(self, signals: Mapping[str, Signal], machine: Machine) -> Mapping[str, Signal]:
        link = int(self.location["link"])
        name = f"imu/link{link}/specific_force"
        values = signals[name].values.copy()
        values[:, 1] *= 1 + self.sizes["g"] * signals["joint/position"].values[:, link - 1]
        return {name: replace(signals[name], values=values)}


class CreepingMarker(OutputEffect):
    """A coordinate of a marker is read the farther off, the later it is."""

    id = "hidden_marker"
    at = ("marker",)
    table: ClassVar = NUMBER
    axis: str
    sizes: Mapping[str, float]

    def observe(self, signals: Mapping[str, Signal], machine: Machine) -> Mapping[str, Signal]:
        values, time = signals["markers"].values.copy(), signals["markers"].time
        values[:, 3 * (int(self.location["marker"]) - 1) + "xyz".index(self.axis)] += self.sizes["speed"] * time
        return {"markers": replace(signals["markers"], values=values)}


class Hardening(ModelEffect):
    """A link's bending moment grows with the cube of its curvature."""

    id = "hidden_link"
    at = ("link",)
    table: ClassVar = NUMBER
    sizes: Mapping[str, float]

    def edit(self, spec: mujoco.MjSpec, machine: Machine) -> None:
        for hinge, length in bent_by(spec, machine, int(self.location["link"]), "v"):
            hinge.stiffness[2] += hinge.stiffness[0] * self.sizes["cube"] / length**2


class Ground(ModelEffect):
    """The machine pitches at the origin, on ground whose moment grows with the cube of the angle as well."""

    id = "hidden_ground"
    table: ClassVar = NUMBER
    sizes: Mapping[str, float]

    def edit(self, spec: mujoco.MjSpec, machine: Machine) -> None:
        base, s = spec.body("base"), self.sizes
        base.explicitinertial, base.mass, base.inertia = True, 1.0, [1.0, 1.0, 1.0]
        joint = base.add_joint(name="ground", axis=[0.0, 1.0, 0.0])
        joint.stiffness = [s["stiffness"], 0.0, s["stiffness"] * s["hardness"]]
        joint.damping[0] = machine.damping.relaxation_time * s["stiffness"]


class Drag(ModelEffect):
    """A ball at the tip, or on the middle marker of a link, in a fluid: MuJoCo's rho C pi r^2 |v| v.

    A test of the laws holds that against its power.
    """

    id = "hidden_drag"
    table: ClassVar = NUMBER
    sizes: Mapping[str, float]

    def edit(self, spec: mujoco.MjSpec, machine: Machine) -> None:
        spec.option.density, radius = 1e-4, 0.05
        link = self.location.get("link")
        point = spec.site(f"marker{3 * int(link) - 4}" if link else "tip")
        ball = point.parent.add_geom(type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[radius, 0, 0], pos=point.pos)
        ball.mass, ball.contype, ball.conaffinity, ball.fluid_ellipsoid = 0.0, 0, 0, 1.0
        ball.fluid_coefs = [self.sizes["c"] / (1e-4 * np.pi * radius**2), 0.0, 0.0, 0.0, 0.0]


class MiddleDrag(Drag):
    """Of a link."""

    at = ("link",)


MOVING = {"hardening": Hardening, "tip_drag": Drag, "middle_drag": MiddleDrag, "ground": Ground}
"""Forms that move the machine otherwise."""


class Shove(ForceEffect):
    """Somebody pushes: bumps in time at one point, across the boom's plane and upwards."""

    id = "hidden_shove"
    table: ClassVar = NUMBER
    point: str
    sizes: Mapping[str, float]

    def force(self, motion: Motion) -> Mapping[str, Array]:
        (up, left), slew = history(self.sizes, motion.time), motion.joints[:, 0]
        return {self.point: np.stack([-np.sin(slew) * left, np.cos(slew) * left, up], axis=1)}


def history(sizes: Mapping[str, float], time: Array) -> Array:
    """Of a shove, upwards and to the left, (2, n), N."""
    bumps = [s * np.exp(-(((time - sizes[f"at{k}"]) / sizes["width"]) ** 2)) for k, s in enumerate((1, -1, 1))]
    return np.outer([np.sin(sizes["way"]), np.cos(sizes["way"])], sizes["peak"] * np.sum(bumps, axis=0))


POINTS = {"tip": "the tip", **{f"marker{3 * link - 4}": f"the middle of link {link}" for link in (3, 4, 5)}}


def shove(rng: np.random.Generator) -> dict[str, Any]:
    """At a random point, the further in, the harder."""
    k = int(rng.integers(4))
    point, times = list(POINTS)[k], np.sort(rng.uniform([4, 14, 30], [10, 26, 50]))
    sizes = {"peak": rng.uniform(300, 600) * (1, 4, 2, 1.5)[k], "way": rng.uniform(-np.pi, np.pi)}
    sizes |= {"width": rng.uniform(0.8, 2.5), **{f"at{j}": t for j, t in enumerate(times)}}
    return {"form": "shove", "place": {"point": point}, "sizes": {n: float(v) for n, v in sizes.items()}, "terms": {}}


def drawn(form: str, machine: Machine, rng: np.random.Generator) -> dict[str, Any]:
    """A form at a random place of random size: what is sealed."""
    cylinder = int(rng.integers(2, 4))
    place: dict[str, Any] = {"cylinder": cylinder}
    lengths = np.concatenate([_lengths(machine, name)[:, cylinder - 2] for name in TRAIN])
    low, high = lengths.min(), lengths.max()
    sign = float(rng.choice([-1, 1]))
    if form == "load_friction":
        sizes, terms = {"mu": rng.uniform(0.02, 0.08)}, {"load_friction": "mu"}
    elif form == "ripple":
        period = (high - low) / rng.uniform(1.5, 8)
        sizes = {"amplitude": rng.uniform(3e3, 1e4), "period": period, "phase": rng.uniform(-np.pi, np.pi)}
        terms = {"ripple": "amplitude"}
    elif form == "tip_drag":
        place, sizes, terms = {}, {"c": rng.uniform(60, 250)}, {"drag": "c"}
    elif form == "middle_drag":
        link = int(rng.integers(3, 6))  # link 2 hardly moves
        place, sizes, terms = {"link": link}, {"c": rng.uniform(150, 600) * (3, 1.5, 1)[link - 3]}, {"drag": "c"}
    elif form == "creeping_marker":
        place = {"marker": int(rng.integers(1, 13)), "axis": str(rng.choice(list("xyz")))}
        sizes, terms = {"speed": sign * rng.uniform(3e-4, 2e-3)}, {"drift": "speed"}
    elif form == "hardening":
        link = int(rng.integers(2, 5))
        share = rng.uniform(0.2, 0.8)
        place = {"link": link, "bends": "v"}
        sizes, terms = {"cube": share * (machine.links[link - 2].length / BEND) ** 2}, {"cube": "cube"}
    elif form == "ground":
        place, stiffness = {"axes": "roll+pitch"}, rng.uniform(2e7, 1e8)  # pitch: motions that slew little do not roll
        sizes = {"stiffness": stiffness, "hardness": rng.uniform(1, 5) / (MOMENT / stiffness) ** 2}
        sizes["give"] = 1 / stiffness
        terms = {"pitch_hard_give": "give"}
    elif form == "sag":
        sizes, terms = {"a": rng.uniform(1, 5)}, {"sag": "a"}
    elif form == "gain" and rng.random() < 0.5:
        place = {"link": int(rng.integers(2, 6)), "sensor": "specific_force", "axis": "y"}
        sizes, terms = {"g": sign * rng.uniform(0.02, 0.08)}, {"scale_angle": "g"}
    elif form == "gain":
        angle = float(rng.uniform(*np.percentile(_angles(TRAIN[0])[:, cylinder - 1], [20, 80])))
        sizes, terms = {"g": sign * rng.uniform(0.03, 0.12), "angle": angle}, {"load_angle": "g", "load_scale": ""}
    elif form == "memory":
        sizes, terms = {"force": sign * rng.uniform(8e3, 3e4), "tau": rng.uniform(0.8, 4)}, {"after_stop": "force"}
    elif form == "stop":
        at = low + rng.uniform(0.3, 0.7) * (high - low)
        sizes = {"stiffness": rng.uniform(1e5, 5e5), "at": at, "side": sign}
        terms = {"upper_stop" if sign > 0 else "lower_stop": "stiffness"}
    else:
        sizes, terms = {"drag": rng.uniform(3e7, 1.5e8)}, {"drag": "drag"}
    return {"form": form, "place": place, "sizes": {k: float(v) for k, v in sizes.items()}, "terms": terms}


def _angles(name: str) -> Array:
    return CATALOGUE[name].joint_path(np.arange(0, CATALOGUE[name].duration, 0.1))[0]


def _lengths(machine: Machine, name: str) -> Array:
    return cylinder_lengths(machine, _angles(name))


def eyes_of(machine: Machine) -> list[Detectability]:
    """How plainly effects show in training and held out."""
    return [Detectability(machine, tuple(CATALOGUE[name] for name in names)) for names in (TRAIN, HOLDOUT)]


def seen(form: str, machine: Machine, rng: np.random.Generator, eyes: Sequence[Detectability]) -> dict[str, Any]:
    """A form that shows in training and held out, or of TRIES the one that shows most."""
    found: list[tuple[float, dict[str, Any]]] = []
    while len(found) < TRIES and (not found or found[-1][0] < VISIBLE):
        truth = drawn(form, machine, rng)
        found.append((min(eye.visibility([effect_of(truth)]) for eye in eyes), truth))
    visibility, truth = max(found, key=lambda one: one[0])
    return {**truth, "visibility": visibility}


def effect_of(truth: Mapping[str, Any]) -> Effect:
    """The hidden effect."""
    place = truth["place"]
    if truth["form"] == "shove":
        effect: Effect = Shove(number=1.0)
        object.__setattr__(effect, "sizes", truth["sizes"])
        object.__setattr__(effect, "point", place["point"])
        return effect
    kind = MOVING.get(truth["form"]) or (
        CreepingMarker if "marker" in place else ImuGain if "link" in place else Cylinder
    )
    keys = ("link", "cylinder", "marker")
    site = next(s for s in BOOM_SITES if s.location == {k: v for k, v in place.items() if k in keys})
    effect = kind(site, number=1.0)
    object.__setattr__(effect, "sizes", truth["sizes"])
    object.__setattr__(effect, "form", truth["form"])
    object.__setattr__(effect, "axis", place.get("axis", ""))
    return effect
