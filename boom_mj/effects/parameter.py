"""A number that an effect takes, and how a fit sees it."""

from dataclasses import dataclass

import numpy as np


def behind(unit: str) -> str:
    """A unit as it stands behind a number: " kg", nothing where there is none."""
    return f" {unit}" if unit not in ("", "1") else ""


@dataclass(frozen=True)
class Parameter:
    """A number that an effect takes.

    A fit sees it scaled, c = 0 neutral and |c| = 1 a size worth finding:

        c = (p - p0) / s     "linear",            c = s / p     "inverse": a stiffness, neutral where it is infinite.

    Attributes:
        unit: SI unit, 1 where there is none.
        neutral: value at which the effect vanishes.
        low, high: bounds, the neutral value among them.
        typical: distance from neutral that is worth finding; for an inverse one, the value itself.
        inverse: whether its reciprocal is what acts (stiffness of something that nominally does not give).
        likely: within which machines that serve lie; None where nothing is known. The effect's file says why.
    """

    unit: str
    neutral: float
    low: float
    high: float
    typical: float
    inverse: bool = False
    likely: tuple[float, float] | None = None

    @property
    def bounds(self) -> tuple[float, float]:
        """Least and largest value."""
        return self.low, self.high

    @property
    def ratio(self) -> bool:
        """Whether it multiplies what the machine has, as two such effects do one another; others add up, scaled."""
        return self.neutral == 1.0

    def plausible(self, value: float) -> bool:
        """Whether a value lies within what is physically likely."""
        return self.likely is None or self.likely[0] <= value <= self.likely[1]

    def coordinate(self, value: float) -> float:
        """A value scaled: 0 neutral, 1 typical."""
        return self.typical / value if self.inverse else (value - self.neutral) / self.typical

    def value(self, coordinate: float) -> float:
        """The value of a scaled one, kept within the bounds."""
        if self.inverse:
            found = self.typical / coordinate if coordinate > 0 else np.inf
        else:
            found = self.neutral + coordinate * self.typical
        return float(np.clip(found, self.low, self.high))
