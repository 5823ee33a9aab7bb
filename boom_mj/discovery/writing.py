"""A law as a Python file that the library accepts: an effect like any other."""

import re
import textwrap
from collections.abc import Mapping, Sequence

from boom_mj.diagnosis.named import interval_of
from boom_mj.discovery.discover import Discovery
from boom_mj.discovery.places import NAMES
from boom_mj.discovery.search import FoundLaw
from boom_mj.effects.laws import JointLaw, Law

DIGITS = 4
WIDTH = 110  # characters of a line
HELPERS = ("direction", "fading", "lagged", "rate")
FILE = '''"""{title}

{story}

As an effect, of the size that was found:

    --effects {name}.py --effect {effect}
"""

{imports}

class {kind}({base}):
    """Acts on {acts_on} as `formula` says, with the numbers of `table`."""

    id = "{name}"
    formula = (
{quoted}
    )
{attributes}    table = {{
{table}
    }}
{law}'''
METHOD = """
    def law(self, {arguments}):
        return (
            {summed}
        )
"""


def law_file(found: Discovery, name: str) -> str:
    """The text of a file that defines the law as the effect `name`."""
    law = found.best
    assert law is not None
    effect, kind = law.scored.fit.effects[0], law_type(law)
    methods = hasattr(kind, "law")
    used = [word for word in NAMES if methods and re.search(rf"\b{word}\b", kind.formula)]
    helpers = [word for word in used if word in HELPERS]
    arrays = sorted(word for word in used if word not in HELPERS)
    imports = [f"from numpy import {', '.join(arrays)}", ""] if arrays else []
    imports += ["from boom_mj.effects import Parameter", f"from boom_mj.effects.laws import {law.place.base.__name__}"]
    imports[-1] += "".join(f", {word}" for word in (*(["TEMPERATURE"] if _warm(law) else []), *helpers))
    terms = re.split(r" \+ (?![^(]*\))", kind.formula)
    values = {word: f"{value:.{DIGITS}g}" for word, value in effect.values.items()}
    location = [f"{key}={value}" for key, value in law.place.site.location.items()]
    return FILE.format(
        title=textwrap.fill(
            f"A law found in recordings of {found.model.facts.name}: {with_numbers(law)}, on {law.place.acts_on}.",
            WIDTH,
        ),
        story=story(found),
        name=name,
        effect=f"{name}:{','.join([*location, *(f'{k}={v}' for k, v in values.items())])}",
        imports="\n".join(imports) + "\n",
        kind="".join(part.capitalize() for part in name.split("_")),
        base=law.place.base.__name__,
        quoted="\n".join(f'        "{part}"' for part in [terms[0], *(f" + {term}" for term in terms[1:])]),
        acts_on=law.place.acts_on,
        attributes="".join(f"    {line}\n" for line in _attributes(law)),
        table="\n".join(_rows(law)),
        law=METHOD.format(arguments=", ".join([*kind.variables, *effect.values]), summed="\n            + ".join(terms))
        if methods
        else "",
    )


def _attributes(law: FoundLaw) -> list[str]:
    lines = [f'{key} = "{value}"' for key, value in law.place.attributes.items()]
    if _warm(law):
        lines.append(f"variables = {law.place.base.__name__}.variables | TEMPERATURE")
    if issubclass(law_type(law), JointLaw):
        lines.append("remembers = False  # more than the last two moments, and what filters keep")
    return lines


def _warm(law: FoundLaw) -> bool:
    return "temperature" in law_type(law).variables


def _rows(law: FoundLaw) -> list[str]:
    """Lines of the table: of what is found, the size is what a fit begins with."""
    effect, rows = law.scored.fit.effects[0], []
    for name, (value, low, high) in intervals(law).items():
        p = effect.declared[name]
        if p.neutral == 0:
            numbers = [0.0, -100 * abs(value), 100 * abs(value), abs(value)]
        else:
            numbers = [value, p.low, p.high, p.typical]
        written = ", ".join(f"{number:.{DIGITS}g}" for number in numbers)
        rows.append(
            f'        "{name}": Parameter("{p.unit}", {written}),  # 95 %: {low:.{DIGITS}g} .. {high:.{DIGITS}g}'
        )
    return rows


def law_type(law: FoundLaw) -> type[Law]:
    """The class of a law."""
    kind = type(law.scored.fit.effects[0])
    assert issubclass(kind, Law)
    return kind


def intervals(law: FoundLaw) -> Mapping[str, Sequence[float]]:
    """Value, and ends of its 95 % interval, by parameter."""
    return {name: interval_of(law.scored, k) for k, (_, name, _) in enumerate(law.scored.fit.candidate.parameters)}


def with_numbers(law: FoundLaw) -> str:
    """The formula with its numbers."""
    text = law_type(law).formula
    for name, value in law.scored.fit.effects[0].values.items():
        text = re.sub(rf"\b{name}\b", f"{value:.3g}", text)
    return text.replace("+ -", "- ").replace("- -", "+ ")


def story(found: Discovery) -> str:
    """How far it holds."""
    share = found.closure
    return (
        f"It closes {share.value:.0%} ({share.low:.0%} .. {share.high:.0%}) of the gap of recordings that it was not "
        "found on."
    )
