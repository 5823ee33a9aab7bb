"""Where a law may be, what it may say there, and the class that it is."""

import ast
import operator
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from itertools import chain
from typing import Any

import numpy as np

from boom_mj.discovery.grammar import GRAMMARS, Shape, Term
from boom_mj.effects import Effect, Parameter, Site, Values, laws

Array = np.ndarray
FAR = 1e3  # sizes, to either side, within which a fit may look for a coefficient
PERIODS = np.arange(0.5, 15.1, 0.25)  # of a ripple within its variable's range: one more or less is another minimum
THRESHOLDS = 12  # within a variable's range
TIMES = (0.1, 0.3, 1.0, 3.0, 10.0)  # s, of memories
HARDNESSES = (3e3, 3e4, 3e5)  # 1/rad^2: a secant twice as stiff at 18, 6 and 2 mrad
GRIDS = {"time": TIMES, "hardness": HARDNESSES}
NAMES = {name: getattr(np, name) for name in ("sin", "cos", "pi", "maximum", "minimum", "ones_like", "abs")} | {
    "direction": laws.direction,
    "fading": laws.fading,
    "lagged": laws.lagged,
    "rate": laws.rate,
}
"""What formulas may call."""
OPERATORS: Mapping[type[ast.operator], Callable[[Any, Any], Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.Pow: operator.pow,
}


@dataclass(frozen=True, eq=False)
class Place:
    """A place of a machine.

    Attributes:
        base: the kind of law.
        site: of the machine.
        acts_on: what the law adds to, for people.
        variables: of the law over the training recordings, (n,) each.
        size: of a law that is worth finding, in its unit.
        words: what {x}, {F}, {creep}, {middle}, {warm} of the grammar are here.
        attributes: of the class, such as an IMU's axis.
        sizes: of coefficients whose function is not one of variables.
        channel: signal and column that a sensor's law alters; None of a law that moves the machine.
        thresholds: how many are tried within a variable's range.
        first: how many of its terms are looked at first, the others where these explain much; all if left out.
        sense: the variables in a recording, (n,) each, with their time; None where they are not known beforehand.
    """

    base: type[laws.Law]
    site: Site
    acts_on: str
    variables: Mapping[str, Array]
    size: float
    words: Mapping[str, Any]
    attributes: Mapping[str, str] = field(default_factory=dict)
    sizes: Mapping[str, float] = field(default_factory=dict)
    channel: tuple[str, int] | None = None
    thresholds: int = THRESHOLDS
    first: int | None = None
    sense: Callable[[int], dict[str, Array]] | None = None

    @property
    def terms(self) -> tuple[Term, ...]:
        """Those of its grammar whose variables it knows: a temperature only where it is logged."""
        warm = "temperature" in self.variables
        return tuple(
            term
            for term in GRAMMARS[self.base.__name__]
            if warm or not any("temperature" in part.function for part in term.parts)
        )

    @property
    def named(self) -> dict[str, int | str]:
        """The place as answers say it."""
        return {**self.site.location, **self.attributes}

    def text(self, words: str) -> str:
        """A formula or a unit of the grammar, as it is here."""
        return words.format(**self.words).replace("- -", "+ ")

    def grid(self, shape: Shape) -> Array:
        """Values at which a shape is looked through."""
        if shape.grid in GRIDS:
            return np.array(GRIDS[shape.grid])
        values = self.variables[self._shaped]
        if shape.grid == "period":
            return float(np.ptp(values)) / PERIODS
        return np.linspace(values.min(), values.max(), self.thresholds + 2)[1:-1]

    @property
    def _shaped(self) -> str:
        """The variable that periods and thresholds are of."""
        return next(name for name in ("position", "angle", "slope", "command", "reading") if name in self.variables)

    def typical(self, coefficient: str, function: str, shape: Mapping[str, float]) -> float:
        """A coefficient with which its function is of the size of the law."""
        if coefficient in self.sizes:
            return self.sizes[coefficient]
        values = value_of(self.text(function), {**self.variables, **shape})
        return self.size / max(float(np.sqrt(np.mean(np.square(values)))), 1e-12)


def value_of(formula: str, variables: Mapping[str, Any]) -> Any:
    """A formula of the grammar at given variables; nothing else than NAMES can be called."""
    return _value(_parsed(formula), variables)


@cache
def _parsed(formula: str) -> ast.expr:
    return ast.parse(formula, mode="eval").body


def _value(node: ast.expr, variables: Mapping[str, Any]) -> Any:
    match node:
        case ast.Constant(value=float() | int() as number):
            return number
        case ast.Name(id=name):
            return variables[name] if name in variables else NAMES[name]
        case ast.UnaryOp(op=ast.USub(), operand=operand):
            return -_value(operand, variables)
        case ast.BinOp(left=left, op=op, right=right):
            return OPERATORS[type(op)](_value(left, variables), _value(right, variables))
        case ast.Call(func=ast.Name(id=name), args=arguments):
            return NAMES[name](*(_value(argument, variables) for argument in arguments))
    raise AssertionError(f"the grammar has no {ast.unparse(node)}")


def law_class(place: Place, terms: Sequence[Term], sizes: Mapping[str, float] | None = None) -> type[Effect]:
    """The law that a sum of terms is at a place.

    Args:
        sizes: of its parameters, where they are known better.
    """
    sizes, table, functions = sizes or {}, dict[str, Parameter](), []
    for term in terms:
        shape = {}
        if term.shape:
            grid = place.grid(term.shape)
            middle = sizes.get(term.shape.name, float(np.median(grid)))
            shape = {term.shape.name: middle}
            table[term.shape.name] = shape_parameter(place, term.shape, middle)
        for part in term.parts:
            size = abs(sizes.get(part.coefficient, 0.0)) or place.typical(part.coefficient, part.function, shape)
            unit = place.text(part.unit)
            table[part.coefficient] = Parameter(unit, 0.0, -FAR * size, FAR * size, size)
            functions.append(f"{part.coefficient} * {place.text(part.function)}")
    formula = " + ".join(functions)
    shapes = [term.shape for term in terms if term.shape]
    body: dict[str, Any] = {
        "id": "+".join([place.base.__name__, *place.attributes.values(), *(term.name for term in terms)]),
        "__doc__": f"{formula}, on {place.acts_on}.",
        "table": table,
        "formula": formula,
        "variables": {**place.base.variables, **(laws.TEMPERATURE if "temperature" in formula else {})},
        "screening": classmethod(lambda cls, site, lines_hz=(): _points(place, terms[0], table)),
        "combine": classmethod(lambda cls, site, points, weights: _sum(points, weights, [s.name for s in shapes])),
        **place.attributes,
    }
    if hasattr(place.base, "law"):
        body["remembers"] = False
        body["law"] = lambda self, **variables: value_of(formula, variables)
    return type("FoundLaw", (place.base,), body)


def first_order(place: Place, term: Term) -> type[Effect]:
    """The law that one term is at a place, as it is screened: small."""
    kind = law_class(place, (term,))
    if getattr(kind, "sees", "") == "simulated":
        kind.sees = "nominal"  # type: ignore[attr-defined]
    return kind


def shape_parameter(place: Place, shape: Shape, start: float) -> Parameter:
    """A shape with its bounds: those of its grid, and what lies between two of its points is worth a step."""
    grid = np.sort(place.grid(shape))
    low, high = (grid[0] / 3, grid[-1] * 3) if shape.grid != "threshold" else (grid[0], grid[-1])
    step = 0.05 * start if shape.grid != "threshold" else float(np.ptp(grid)) / len(grid)
    inside = float(np.clip(start, low, high))
    return Parameter(place.text(shape.unit), inside, float(low), float(high), max(step, 1e-9))


def _points(place: Place, term: Term, table: Mapping[str, Parameter]) -> list[list[dict[str, float]]]:
    """Groups of points that add up: a term's coefficients, one after the other, for every shape of the grid."""
    shapes = [{term.shape.name: float(v)} for v in place.grid(term.shape)] if term.shape else [{}]
    return [[{part.coefficient: table[part.coefficient].typical, **s} for part in term.parts] for s in shapes]


def _sum(points: Sequence[Values], weights: Array, shapes: Sequence[str]) -> dict[str, float]:
    values = {name: value for name, value in points[0].items() if name in shapes}
    for name in dict.fromkeys(chain.from_iterable(points)):
        if name not in shapes:
            values[name] = float(sum(weight * point.get(name, 0.0) for point, weight in zip(points, weights)))
    return values
