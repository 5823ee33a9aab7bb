"""The machine, coloured by where the gap is sensed: every kind of subject has a picture of its own."""

from boom_mj.report.diagnosis import boom, tree
from boom_mj.report.diagnosis.view import View
from boom_mj.report.section import Section
from boom_mj.systems.boom.system import BoomSystem
from boom_mj.systems.mjcf import MjcfSystem


def section(view: View) -> Section:
    match view.subject:
        case BoomSystem() as subject:
            kind, facts = "boom.html", boom.picture(view, subject)
        case MjcfSystem() as subject:
            kind, facts = "tree.html", tree.picture(view, subject)
        case _:
            raise TypeError(f"no picture for a {type(view.subject).__name__}")
    return Section("machine", "On the machine", {"kind": kind, **facts})
