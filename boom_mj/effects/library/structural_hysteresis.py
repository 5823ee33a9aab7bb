"""Dry friction in a bolted link."""

from collections.abc import Sequence

import mujoco

from boom_mj.effects import Array, ModelEffect, Parameter, Site, Values
from boom_mj.effects.spec_edits import link_hinges
from boom_mj.machine import Machine


class StructuralHysteresis(ModelEffect):
    """An elasto-slip (Jenkins) element in parallel to a link's bending: a spring that slips at a torque.

    It turns with the link's tip against its clamp and starts relaxed. Damping falls with the amplitude, the rest
    position depends on the way there. MuJoCo's `springyield` is the slider.
    """

    id = "structural_hysteresis"
    at = ("joint",)
    needs = frozenset({"boom", "clamp"})
    table = {
        "stiffness": Parameter("N m/rad", 0.0, 0.0, 1e9, 1e6),
        "slip_torque": Parameter("N m", 0.0, 0.0, 1e6, 2e3),
    }
    confused_with = ("structural_damping", "joint_friction")
    separating_experiment = "release_stretched_vertical_half"

    def edit(self, spec: mujoco.MjSpec, machine: Machine) -> None:
        stiffness, slip = self.values["stiffness"], self.values["slip_torque"]
        if stiffness == 0 or slip == 0:
            return
        tendon = spec.add_tendon(name=f"slider{self.location['joint']}")
        for hinge in link_hinges(spec, int(self.location["joint"]), "v"):
            tendon.wrap_joint(hinge.name, 1.0)
        tendon.stiffness[0] = stiffness
        tendon.springlength = [0.0, 0.0]
        tendon.springyield = slip / stiffness

    @classmethod
    def screening(cls, site: Site, lines_hz: Sequence[float] = ()) -> list[list[dict[str, float]]]:
        """Both parameters act together or not at all: three slip torques."""
        return [[{"stiffness": k, "slip_torque": t}] for k, t in ((1e6, 5e2), (1e6, 2e3), (3e6, 6e3))]

    @classmethod
    def combine(cls, site: Site, points: Sequence[Values], weights: Array) -> dict[str, float]:
        """The point itself: its effect does not grow with its parameters."""
        return dict(points[0])
