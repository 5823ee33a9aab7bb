"""Oil that gives."""

from collections.abc import Sequence

import mujoco
import numpy as np

from boom_mj.effects import DETUNING, ModelEffect, Parameter, Site
from boom_mj.effects.spec_edits import add_series_hinge
from boom_mj.machine import Machine


class HydraulicCompliance(ModelEffect):
    """A spring between the angle sensor (drive side) and the link that a cylinder moves, and what damps it.

    The damping is `damping_factor` times the relaxation time of the links times the stiffness: oil, hoses and seals are
    no steel, and no data sheet tells it.
    """

    id = "hydraulic_compliance"
    at = ("joint",)
    needs = frozenset({"boom", "cylinder"})
    table = {
        "stiffness": Parameter("N m/rad", np.inf, 1e5, np.inf, 3e7, inverse=True),
        "damping_factor": Parameter("1", 1.0, 0.0, 5.0, 0.5),
    }
    confused_with = ("link_stiffness", "base_compliance")
    separating_experiment = "chirp_joint2"
    sizes = DETUNING

    def edit(self, spec: mujoco.MjSpec, machine: Machine) -> None:
        joint = int(self.location["joint"])
        add_spring(spec, machine, joint, f"joint{joint}_oil", self.values["stiffness"], self.values["damping_factor"])

    @classmethod
    def screening(cls, site: Site, lines_hz: Sequence[float] = ()) -> list[list[dict[str, float]]]:
        """The stiffness alone: without it nothing is damped."""
        return [[{"stiffness": cls.table["stiffness"].value(size)}] for size in cls.sizes]


def add_spring(
    spec: mujoco.MjSpec, machine: Machine, joint: int, name: str, stiffness: float, factor: float = 1.0
) -> None:
    """A damped spring (N m/rad) in series with a drive; none where it is infinite.

    Args:
        factor: of its damping, in terms of what the links' relaxation time gives.
    """
    if np.isfinite(stiffness):
        hinge = add_series_hinge(spec, joint, name)
        hinge.stiffness[0], hinge.damping[0] = stiffness, factor * machine.damping.relaxation_time * stiffness
