"""Where the gap of the nominal model lies, and what would have to push to close it."""

from boom_mj.gap.diagnose import QUIET
from boom_mj.gap.subject import Push
from boom_mj.report.diagnosis.heat import heat_map
from boom_mj.report.diagnosis.view import View
from boom_mj.report.section import Section
from boom_mj.report.words import number, place_name

TOP = 3  # places in words
PUSHES = 5  # listed
BENDING = {"v": "bending, vertical", "w": "bending, horizontal"}


def section(view: View) -> Section:
    found = heat_map(view.cells)
    top = sorted(found.rows, key=lambda row: -row.total.share)[:TOP]
    facts = {
        "map": found,
        "top": [(place_name(row.sensor, row.link), row.total.share) for row in top],
        "pushes": [_shown(push) for push in view.found.pushes if push.ratio > QUIET][:PUSHES],
    }
    return Section("where", "Where it lies", facts)


def _shown(push: Push) -> tuple[str, str, str, float]:
    """Part, direction, force and ratio as the table has them."""
    part, direction = f"{push.part[:-1]} {push.part[-1]}", BENDING.get(push.direction, push.direction)
    return part, direction, f"{number(push.force)} {push.unit}", push.ratio
