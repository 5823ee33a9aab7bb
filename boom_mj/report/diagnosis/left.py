"""What is left: how much, where, and what it looks like."""

import numpy as np

from boom_mj.diagnosis.localisation import looks_like
from boom_mj.report.diagnosis.heat import heat_map
from boom_mj.report.diagnosis.view import View
from boom_mj.report.section import Section
from boom_mj.report.words import spoken

LISTED = 6  # places


def section(view: View) -> Section:
    gaps, healthy = view.answer["gap"]["holdout"], view.found.criteria.healthy_gap
    quiet = gaps["after"] is None or gaps["after"] <= healthy
    facts = {
        "after": gaps["after"],
        "quiet": quiet,
        "share": share_left(gaps["before"], gaps["after"], healthy) if view.corrected else None,
        "looks": None if quiet else spoken(looks_like(view.found.model, view.after)),
        "map": heat_map(view, view.cells_left) if view.corrected and not quiet else None,
        "places": [cell for cell in view.cells_left if cell.gap > 1][:LISTED],
        "directions": len(view.order["direction"]) > 1,
        "corrected": view.corrected,
    }
    return Section("left", "What is left", facts)


def share_left(before: float | None, after: float | None, healthy: float) -> float | None:
    """Share of the squared gap above the floor that the explanation leaves; None where there was no gap."""
    if before is None or after is None or before <= healthy:
        return None
    return float(np.clip((after**2 - 1) / (before**2 - 1), 0, 1))
