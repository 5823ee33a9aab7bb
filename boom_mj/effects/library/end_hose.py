"""The hose at the end of the boom."""

import mujoco

from boom_mj.effects import DETUNING, ModelEffect, Parameter
from boom_mj.machine import Machine

DAMPING = 0.02  # of the critical


class EndHose(ModelEffect):
    """A pendulum on the tip: a mass that hangs at `end_hose.length` and swings both ways."""

    id = "end_hose"
    needs = frozenset({"boom"})
    table = {"mass": Parameter("kg", 0.0, 0.0, 500.0, 40.0)}
    confused_with = ("tip_payload", "pump_pulsation")
    separating_experiment = "slew_t"
    sizes = DETUNING

    def edit(self, spec: mujoco.MjSpec, machine: Machine) -> None:
        mass, length = self.values["mass"], machine.end_hose.length
        if mass == 0:
            return
        tip = spec.site("tip")
        # straight on in the frame of the stretched link; the first hinge lets it hang down whatever the boom's pitch
        hose = tip.parent.add_body(name="hose", pos=tip.pos, explicitinertial=True)
        hose.mass, hose.ipos, hose.inertia = mass, [0, -length, 0], [1e-2 * mass] * 3
        damping = 2 * DAMPING * mass * length**2 * (machine.gravity / length) ** 0.5
        for name, axis in (("hose_pitch", [0, 0, 1]), ("hose_roll", [1, 0, 0])):
            hose.add_joint(name=name, axis=axis).damping[0] = damping
