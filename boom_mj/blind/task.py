"""The task as those read it who answer cases with a method of their own: README.md of a set of cases."""

import json
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from boom_mj.blind.plant import AS_BUILT, DAMPING, MASS, STIFFNESS, ZERO_OFFSET
from boom_mj.effects import BOOM_SITES, Effect, Site, builtin

EXAMPLE: Mapping[str, Any] = {
    "verdict": "explained",
    "effects": [
        {
            "id": "link_stiffness",
            "location": {"link": 4, "axis": "w"},
            "parameters": {"factor": {"value": 0.91, "low": 0.88, "high": 0.94}},
            "probability": 0.8,
        }
    ],
    "others": {"outside_library": 0.15, "none": 0.05},
    "cpu_s": 12.0,
}
BOOM = """It is the machine of `machine.toml`, but for what
any two machines differ in, and for what has gone wrong with it: nothing, one effect, or several, from the table
below or from none. Name what is wrong, where, and how large it is. Healthy machines differ by up to {offset:.1f}
deg in the zeros of their joint sensors, {stiffness:.1%} in the stiffness of each link, {mass:.1%} in its mass and
{damping:.0%} in damping; a few cases may be of machines as built, which differ by {as_built} in stiffness, mass and
damping.

| file | holds |
|---|---|
| `machine.toml` | the nominal machine |
| `CASE/train/*.mcap` | recordings to work with (ROS 2 messages in MCAP files) |"""
MJCF = """It is the machine of `model.xml`, but for what
any model lacks, and for what has gone wrong with it: nothing, one effect, or two, from the table below or from none.
Name what is wrong, where, and how large it is. Every machine may have a few small effects besides, a fifth of what is
worth finding: naming one is neither asked for nor wrong. Ours answers a case by

    python -m boom_mj gap diagnose CASE/train/*.csv --holdout CASE/holdout/*.csv --map map.toml --model model.xml

| file | holds |
|---|---|
| `model.xml` | the nominal machine |
| `map.toml` | which field of a recording is which joint, actuator or sensor, its unit and its noise |
| `CASE/train/*.csv` | recordings to work with |"""
TEXT = """# What is wrong with these machines?

Every folder here is a case: one machine, recorded by its sensors. {machine}
| `CASE/holdout/*.{ending}` | recordings that a method is free to use, to check itself |
| `CASE/withhold.json` | `without`: ids of the table that the method must do without in this case |
| `answer.schema.json` | JSON Schema of an answer |
| `seal.sha256` | SHA-256 of the sealed truth, written with the cases |

## An answer

One JSON file a case, `CASE.json`, all in one folder. `gap diagnose --json` writes such files, too.

```json
{example}
```

- `verdict`: `consistent` where nothing is wrong; `explained` where `effects` are all that is; `partial` where they
  are but a part; `ambiguous` where `ties` lists other explanations that do as well; `unexplained` where something
  is wrong and no effect of the table, but for the withheld one, explains it. The first and the last name no
  effects.
- `effects`: `id`, `location` and sizes as in the table, in SI units, with their 95 % intervals.
- `probability`: of a cause, or beside `verdict` of the answer as a whole; `others`: that nothing is wrong (`none`),
  that no effect of the table explains it (`outside_library`). They are scored where they are given.
- `cpu_s`, or else `wall_s`: seconds that it took on one core, of the processor or by the clock.

Only `verdict` and `effects` must be there. A case without a file is a miss.

## How it is scored

`python -m boom_mj gap blind score` with the seal, once that is open: effects right and at their place; false
alarms; where an effect is withheld or outside the table, `unexplained` (or `ambiguous` with what it is known to be
confused with) is right; how many intervals hold the truth; Brier score and calibration error of the probabilities.

## Effects

| id | location | sizes |
|---|---|---|
{effects}
"""


def readme() -> str:
    """README.md of a boom's set."""
    machine = BOOM.format(
        offset=np.degrees(ZERO_OFFSET),
        stiffness=STIFFNESS,
        mass=MASS,
        damping=DAMPING,
        as_built=", ".join(f"{share:.0%}" for share in AS_BUILT),
    )
    return _text(machine, "mcap", BOOM_SITES)


def mjcf_readme(sites: Sequence[Site]) -> str:
    """README.md of the set of a machine with a channel map."""
    return _text(MJCF, "csv", sites)


def _text(machine: str, ending: str, sites: Sequence[Site]) -> str:
    kinds = [kind for kind in builtin().values() if kind.competes and kind.allowed(sites)]
    rows = "\n".join(_row(kind, kind.allowed(sites)) for kind in kinds)
    return TEXT.format(machine=machine, ending=ending, example=json.dumps(EXAMPLE, indent=1), effects=rows)


def _row(kind: type[Effect], sites: Sequence[Site]) -> str:
    declared = {name: parameter for site in sites for name, parameter in kind.parameters(site).items()}
    sizes = ", ".join(f"`{name}` {p.unit}, neutral {p.neutral:g}" for name, p in declared.items())
    return f"| `{kind.id}` | {_places(sites)} | {sizes} |"


def _places(sites: Sequence[Site]) -> str:
    keys = dict.fromkeys(key for site in sites for key in site.keys)
    choices = {key: dict.fromkeys(json.dumps(site.location[key]) for site in sites) for key in keys}
    return ", ".join(f"`{key}`: {', '.join(values)}" for key, values in choices.items()) or "`{}`"
