"""The machine, coloured by where the gap is sensed: every kind of system has a picture of its own."""

from collections.abc import Callable, Mapping
from typing import Any

from boom_mj.report.diagnosis import boom, tree
from boom_mj.report.diagnosis.view import View
from boom_mj.report.section import Section
from boom_mj.systems.as_built import nominal_system

PICTURES: Mapping[str, tuple[str, Callable[[View, Any], Mapping[str, Any]]]] = {
    "boom": ("boom.html", boom.picture),
    "mjcf": ("tree.html", tree.picture),
}


def section(view: View) -> Section:
    template, picture = PICTURES[view.facts.kind]
    return Section("machine", "On the machine", {"kind": template, **picture(view, nominal_system(view.system))})
