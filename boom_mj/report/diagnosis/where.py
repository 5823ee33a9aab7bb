"""Where the gap of the machine as built lies."""

from boom_mj.report.diagnosis.heat import heat_map
from boom_mj.report.diagnosis.view import View
from boom_mj.report.section import Section

TOP = 3  # places in words


def section(view: View) -> Section:
    found = heat_map(view, view.cells)
    top = sorted(found.rows, key=lambda row: -row.total.share)[:TOP]
    facts = {
        "map": found,
        "top": [(view.place_name(row.sensor, row.link), row.total.share) for row in top],
        "frames": view.facts.wording.frames,
    }
    return Section("where", "Where it lies", facts)
