"""A link longer or shorter than its drawing."""

import mujoco
import numpy as np

from boom_mj.effects import ModelEffect, Parameter
from boom_mj.effects.spec_edits import link_bodies, link_hinges, second_moment, set_second_moment
from boom_mj.machine import Machine


class LinkLength(ModelEffect):
    """A link as long as its drawing tells and some more; what lies on it keeps its share of the length.

    Masses are those of the drawing, and E I, so that a longer link gives more.
    """

    id = "link_length"
    at = ("link",)
    needs = frozenset({"boom"})
    table = {"error": Parameter("m", 0.0, -1.0, 1.0, 0.02, likely=(-0.3, 0.3))}  # a wrong drawing; welds miss by 0.01
    confused_with = ("marker_slip", "camera_pose", "link_mass")
    separating_experiment = "sweep"

    def edit(self, spec: mujoco.MjSpec, machine: Machine) -> None:
        number, error = int(self.location["link"]), self.values["error"]
        if not error:
            return
        bodies = link_bodies(spec, number)
        stretch = 1 + error / machine.links[number - 2].length
        along = np.array([stretch, 1.0, 1.0])
        for body in bodies:  # each has the frame of the link's tip
            body.ipos = body.ipos * along
            set_second_moment(body, np.outer(along, along) * second_moment(body))
            for part in (*body.joints, *body.sites, *body.geoms):
                part.pos = part.pos * along
            for drawn in filter(None, (spec.mesh(geom.meshname) for geom in body.geoms)):
                drawn.scale = drawn.scale * along
        for axis in ("v", "w", "torsion"):
            for hinge in link_hinges(spec, number, axis):
                hinge.stiffness, hinge.damping = hinge.stiffness / stretch, hinge.damping / stretch
        bodies[0].pos = np.add(bodies[0].pos, [error, 0.0, 0.0])
