"""What an answer to a case holds: a subset of what `gap diagnose --json` writes, checked before it is graded."""

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, FiniteFloat, ValidationError, model_validator

from boom_mj.effects import effect_library
from boom_mj.errors import InputError, shown
from boom_mj.files import read_json

Number = FiniteFloat | None
Share = Annotated[
    FiniteFloat,
    Field(ge=0, le=1),
    BeforeValidator(lambda value: round(value, 9) if isinstance(value, float) else value),  # a sum of many
]
Probability = Share | None
OPTIONAL: Mapping[str, Any] = {"sentence": "", "ties": (), "gap": {}, "others": {}}


class _Part(BaseModel):
    model_config = ConfigDict(extra="allow", strict=True, use_attribute_docstrings=True)


class Size(_Part):
    """A parameter of a cause with its 95 % interval; null where an end is open."""

    value: FiniteFloat
    low: Number = None
    high: Number = None

    @model_validator(mode="after")
    def _is_an_interval(self) -> Self:
        if self.low is not None and self.high is not None and self.low > self.high:
            raise ValueError(f"low = {self.low:g} lies above high = {self.high:g}")
        return self


class Place(_Part):
    """An effect of the library at its place."""

    id: str
    location: dict[str, int | str] = {}
    """Such as {"link": 4, "axis": "w"}; {} is the machine as a whole."""


class Cause(Place):
    """What the machine has."""

    parameters: dict[str, Size] = {}
    """By name, in SI units; those left out are not scored."""
    probability: Probability = None
    """That the machine has it."""


class Others(_Part):
    """Probabilities of what is no cause of the library."""

    outside_library: Probability = None
    none: Probability = None


class Answer(_Part):
    """An answer to one case; more keys may stand beside these."""

    verdict: Literal["consistent", "explained", "ambiguous", "partial", "unexplained"]
    """No gap; causes are named; one of several ties; some causes are sure; a gap and no cause."""
    effects: list[Cause]
    """All that the machine has; none where the verdict is consistent or unexplained."""
    probability: Probability = None
    """That the answer is right; if left out, the least of its causes', or that of `others`."""
    others: Others = Others()
    ties: list[list[Place]] = []
    """Explanations that the data cannot tell apart."""
    wall_s: Number = None
    """Seconds that it took on one core, by the clock."""
    cpu_s: Number = None
    """Processor seconds of all threads, which count instead: other work on the machine does not matter to them."""

    @model_validator(mode="after")
    def _names_what_it_says(self) -> Self:
        if self.verdict in ("explained", "ambiguous", "partial") and not self.effects:
            raise ValueError(f"the verdict is {self.verdict!r} but effects names no cause")
        known = effect_library()
        for cause in self.effects:
            if cause.id not in known:
                raise ValueError(f"there is no effect {shown(cause.id)}; there are {', '.join(known)}")
        return self


def answer_schema() -> dict[str, Any]:
    """JSON Schema (2020-12) of an answer."""
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **Answer.model_json_schema()}


def read_answer(path: Path) -> dict[str, Any]:
    """An answer from its file, with what was left out.

    Raises:
        InputError: the file is no answer; the first thing that is wrong is named.
    """
    content = read_json(path, InputError)
    try:
        Answer.model_validate(content)
    except ValidationError as error:
        first, *others = error.errors()
        place = ".".join(map(str, first["loc"]))
        said = first["msg"].removeprefix("Value error, ")
        said = f"{said[0].lower()}{said[1:]}" if first["type"] == "value_error" else f"{_found(first)}{said}"
        more = f"; {len(others)} more of its values are wrong" if others else ""
        raise InputError(f"{path} is no answer to its case: {f'{place}: ' if place else ''}{said}{more}") from error
    causes = [{"location": {}, "parameters": {}, **cause} for cause in content["effects"]]
    causes = [{**cause, "parameters": _with_ends(cause["parameters"])} for cause in causes]
    return {**OPTIONAL, **content, "effects": causes}


def _found(error: Any) -> str:
    return "" if error["type"] == "missing" else f"{shown(error['input'])} is wrong: "


def _with_ends(parameters: Mapping[str, Any]) -> dict[str, Any]:
    return {name: {"low": None, "high": None, **size} for name, size in parameters.items()}
