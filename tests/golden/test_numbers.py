"""Numbers of the library and of the decision are kept as text: whoever moves one sees it, and says so.

python tests/golden/test_numbers.py > tests/golden/numbers.json
"""

import json
import re
from dataclasses import asdict
from pathlib import Path
from typing import Any

from boom_mj.diagnosis.criteria import described
from boom_mj.effects import BOOM_SITES, effect_library
from boom_mj.effects.site import Site

KEPT = Path(__file__).with_name("numbers.json")
CODE = Path(__file__).parents[2] / "boom_mj"
ROOMS = ("estimation", "diagnosis", "replay/quality")
CONSTANT = re.compile(r"^([A-Z][A-Z_, ]*)(?:: [^=]+)? = (.+?)(?:  # .*)?$", re.M)
OPTION = re.compile(r"^    ([a-z_]+): (?:int|float) = ([-+.e\d]+)$", re.M)
LINES_HZ = (0.5, 2.0)  # of a spectrum that is screened for


def numbers() -> dict[str, Any]:
    """Ranges of every effect, what screening tries of it, every criterion and constant, as JSON holds them."""
    effects = {}
    for name, kind in effect_library().items():
        if not kind.__module__.startswith("boom_mj."):
            continue
        site = next(iter(kind.allowed(BOOM_SITES)), Site())
        ranges = {key: asdict(value) for key, value in kind.parameters(site).items()}
        effects[name] = {"parameters": ranges, "screening": repr(kind.screening(site, LINES_HZ))}
    criteria = {f"{family} {field.name}": {**values} for family, field, values in described()}
    files = [path for room in ROOMS for path in sorted((CODE / room).rglob("*.py"))]
    constants = {str(path.relative_to(CODE)): _own(path.read_text()) for path in files}
    found = {"effects": effects, "criteria": criteria, "constants": {k: own for k, own in constants.items() if own}}
    return json.loads(json.dumps(found, default=str))


def _own(code: str) -> dict[str, str]:
    """Constants of a module and numbers of its options, as they are written."""
    return dict(CONSTANT.findall(code) + OPTION.findall(code))


def test_no_number_moves_unseen() -> None:
    kept, now = json.loads(KEPT.read_text()), numbers()
    for part in kept:
        assert set(kept[part]) == set(now[part])
        moved = {name: (old, now[part][name]) for name, old in kept[part].items() if old != now[part][name]}
        assert not moved, "record them anew, and say so in CHANGELOG.md under Numbers that moved"


if __name__ == "__main__":
    print(json.dumps(numbers(), indent=1))
