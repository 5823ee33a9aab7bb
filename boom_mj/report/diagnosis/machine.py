"""The machine, coloured by where the gap is sensed: every kind of subject has a picture of its own."""

from boom_mj.gap.boom import Boom
from boom_mj.gap.mjcf import Robot
from boom_mj.report.diagnosis import boom, tree
from boom_mj.report.diagnosis.view import View
from boom_mj.report.section import Section


def section(view: View) -> Section:
    match view.subject:
        case Boom() as subject:
            kind, facts = "boom.html", boom.picture(view, subject)
        case Robot() as subject:
            kind, facts = "tree.html", tree.picture(view, subject)
        case _:
            raise TypeError(f"no picture for a {type(view.subject).__name__}")
    return Section("machine", "On the machine", {"kind": kind, **facts})
