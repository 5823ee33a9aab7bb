"""What the values of a machine file may be: the base of its sections, and numbers with bounds."""

from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field, FiniteFloat

LARGEST = 1e15  # in SI: nothing of a machine is larger
Number = Annotated[FiniteFloat, Field(ge=-LARGEST, le=LARGEST)]
Positive = Annotated[FiniteFloat, Field(gt=0, le=LARGEST)]
NonNegative = Annotated[FiniteFloat, Field(ge=0, le=LARGEST)]
Pair = tuple[Positive, Positive]
Point2 = tuple[Number, Number]
Point3 = tuple[Number, Number, Number]


class Frozen(BaseModel):
    """A section of the machine file: immutable, and unknown keys are refused."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=False)
