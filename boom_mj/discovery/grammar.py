"""The grammar of laws: terms whose sum, at one place, a law may be.

A term is linear in its coefficients; where it has a shape parameter, such as a period or a threshold, a grid of it is
looked through first. Formulas are Python, as the file of a law holds them; {x} and {F} stand for the units of the
place's coordinate and force, {creep} for the speed over which its dry friction changes sign, {middle} for the middle of
its coordinate's range, {warm} for that of its temperature's.
"""

from collections.abc import Mapping
from dataclasses import dataclass

from boom_mj.effects.spec_edits import BASE_AXES


@dataclass(frozen=True)
class Part:
    """A coefficient times a function of the variables."""

    coefficient: str
    function: str
    unit: str


@dataclass(frozen=True)
class Shape:
    """A parameter that a term is not linear in.

    Attributes:
        name, unit: of the parameter.
        grid: rule by which it is looked through: "period", "threshold", "time" or "hardness".
    """

    name: str
    unit: str
    grid: str


@dataclass(frozen=True)
class Term:
    """What a law may have, in the order of simplicity."""

    name: str
    parts: tuple[Part, ...]
    shape: Shape | None = None


def _term(name: str, function: str, unit: str, shape: Shape | None = None) -> Term:
    return Term(name, (Part(name, function, unit),), shape)


def _ripple(variable: str, unit: str, coordinate: str) -> Term:
    """About the middle of its variable: seen from far off, a phase moves with the period, and fits are stuck."""
    turn = f"(2 * pi * ({variable} - {{middle:.9g}}) / period)"
    parts = (Part("sine", f"sin{turn}", unit), Part("cosine", f"cos{turn}", unit))
    return Term("ripple", parts, Shape("period", coordinate, "period"))


TAU, DRY = Shape("tau", "s", "time"), "direction(speed, {creep:g})"
UPPER, LOWER = Shape("upper", "{x}", "threshold"), Shape("lower", "{x}", "threshold")
DRIVE = (
    _term("offset", "ones_like(speed)", "{F}"),
    _term("viscous", "speed", "{F} s/{x}"),
    _term("dry", DRY, "{F}"),
    _term("one_way_viscous", "abs(speed)", "{F} s/{x}"),
    _term("load_scale", "load", "1"),
    _term("load_friction", f"abs(load) * {DRY}", "1"),
    _term("sag", "load * abs(speed)", "s/{x}"),
    _term("drag", "abs(speed) * speed", "{F} s^2/{x}^2"),
    _term("inertia", "rate(time, speed)", "{F} s^2/{x}"),
    _term("spring", "(position - {middle:.9g})", "{F}/{x}"),
    _term("cubic_spring", "(position - {middle:.9g})**3", "{F}/{x}^3"),
    _term("drift", "time", "{F}/s"),
    _term("upper_stop", "maximum(position - upper, 0)", "{F}/{x}", UPPER),
    _term("lower_stop", "maximum(lower - position, 0)", "{F}/{x}", LOWER),
    _ripple("position", "{F}", "{x}"),
    _term("memory", "lagged(time, speed, tau)", "{F} s/{x}", TAU),
    _term("dry_memory", f"lagged(time, {DRY}, tau)", "{F}", TAU),
    _term("after_stop", f"fading(time, {DRY}, tau)", "{F}", TAU),
)
WARM = "(temperature - {warm:.9g})"
WARM_DRIVE = (
    _term("warm", WARM, "{F}/K"),
    _term("warm_viscous", f"speed * {WARM}", "{F} s/({x} K)"),
    _term("warm_dry", f"{DRY} * {WARM}", "{F}/K"),
    _term("warm_load", f"load * {WARM}", "1/K"),
)
"""Of a joint whose temperature is logged, from the middle of its range."""
"""Of what drives: a cylinder, or the joint of any machine."""
CYLINDER = (*DRIVE, _term("load_angle", "load * angle", "1/rad"))
SENSOR = (
    _term("scale", "reading", "1"),
    _term("square", "reading**2", "1/({F})"),
    _term("odd_square", "abs(reading) * reading", "1/({F})"),
    _term("cube", "reading**3", "1/({F})^2"),
    _term("drift", "time", "{F}/s"),
    _term("drifting_scale", "reading * time", "1/s"),
)
WARM_CHANNEL = (_term("warm", WARM, "{F}/K"), _term("warm_scale", f"reading * {WARM}", "1/K"))
AXIS = (
    _term("offset", "ones_like(reading)", "{F}"),
    *SENSOR,
    _term("tilt", "angle", "{F}/rad"),
    _term("scale_angle", "reading * angle", "1/rad"),
)
ANGLE = (
    _term("scale", "angle", "1"),
    _term("square", "angle**2", "1/rad"),
    _term("cube", "angle**3", "1/rad^2"),
    _ripple("angle", "rad", "rad"),
    _term("upper_stop", "maximum(angle - upper, 0)", "1", Shape("upper", "rad", "threshold")),
)
ACTUATOR = (
    _term("scale", "command", "1"),
    _term("offset", "ones_like(command)", "{x}"),
    _term("upper_dead_zone", "maximum(minimum(command, upper), 0)", "1", UPPER),
    _term("lower_dead_zone", "minimum(maximum(command, lower), 0)", "1", LOWER),
    _term("odd_square", "abs(command) * command", "1/({x})"),
)
LINK = (
    _term("linear", "E I curvature", "1"),
    _term("offset", "E I", "1/m"),
    _term("cube", "E I curvature^3", "m^2"),
    _term("square", "E I curvature^2", "m"),
    Term(
        "stop",
        (Part("stop_stiffness", "maximum(slope - stop, 0)", "N m/rad"),),
        Shape("stop", "rad", "threshold"),
    ),
)
POINT = (
    _term("drag", "-|velocity| velocity", "N s^2/m^2"),
    _term("weight", "downwards", "N"),
    _term("inertia", "-acceleration", "kg"),
)
BASE = (
    *(_term(f"{axis}_tilt", axis, "rad") for axis in BASE_AXES),
    *(_term(f"{axis}_give", f"{axis} moment", "rad/(N m)") for axis in BASE_AXES),
    *(
        Term(
            f"{axis}_hard_give",
            (Part(f"{axis}_give", f"{axis} moment / (1 + {axis}_hardness {axis}^2)", "rad/(N m)"),),
            Shape(f"{axis}_hardness", "1/rad^2", "hardness"),
        )
        for axis in BASE_AXES
    ),
)
GRAMMARS: Mapping[str, tuple[Term, ...]] = {
    "CylinderLaw": CYLINDER,
    "JointLaw": (*DRIVE, *WARM_DRIVE),
    "ChannelLaw": (*SENSOR, *WARM_CHANNEL),
    "ActuatorLaw": ACTUATOR,
    "ImuLaw": AXIS,
    "MarkerLaw": AXIS,
    "AngleLaw": ANGLE,
    "LinkLaw": LINK,
    "TipLaw": POINT,
    "MiddleLaw": POINT,
    "BaseLaw": BASE,
}
"""Terms by the kind of law."""
