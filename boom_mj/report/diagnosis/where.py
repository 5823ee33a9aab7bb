"""Where the gap of the nominal model lies."""

from boom_mj.gap.diagnose import QUIET
from boom_mj.report.diagnosis.heat import heat_map
from boom_mj.report.diagnosis.section import Section
from boom_mj.report.diagnosis.view import View
from boom_mj.report.diagnosis.words import number, place_name, spaced

TOP = 3  # places in words
PUSHES = 5  # listed


def section(view: View) -> Section:
    found = heat_map(view.cells)
    top = sorted(found.rows, key=lambda row: -row.total.share)[:TOP]
    pushes = [push for push in view.found.pushes if push.ratio > QUIET][:PUSHES]
    facts = {
        "map": found,
        "top": [(place_name(row.sensor, row.link), row.total.share) for row in top],
        "pushes": [(spaced(p.part), p.direction, f"{number(p.force)} {p.unit}", p.ratio) for p in pushes],
    }
    return Section("where", "Where it lies", facts)
