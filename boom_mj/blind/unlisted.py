"""Effects that the library does not hold: what a diagnosis must call unexplained.

Written down here and nowhere else; none is registered, so that no candidate list ever contains one.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import mujoco
import numpy as np
from scipy.signal import lfilter

from boom_mj.effects import Effect, ForceEffect, ModelEffect, Motion, OutputEffect, Parameter, Site
from boom_mj.effects.spec_edits import bent_by, link_hinges
from boom_mj.machine import Machine
from boom_mj.recording import Signal

Array = np.ndarray
BEND = 0.02  # rad, slope that a link of the loaded boom gathers
FAR = 10.0  # rad, where no hinge ever is


class HardeningLink(ModelEffect):
    """A link whose bending stiffness grows with the bend: M = k b (1 + s (b / BEND)^2), shared among its hinges."""

    id = "hardening_link"
    at = ("link",)
    needs = frozenset({"boom"})
    table = {"share": Parameter("1", 0.0, 0.0, 20.0, 0.3)}
    confused_with = ("link_stiffness", "tip_payload")

    def edit(self, spec: mujoco.MjSpec, machine: Machine) -> None:
        hinges = bent_by(spec, machine, int(self.location["link"]), "v")
        whole = sum(length for _, length in hinges)
        for hinge, length in hinges:
            cubic = self.values["share"] * hinge.stiffness[0] * (whole / length / BEND) ** 2
            hinge.stiffness = [hinge.stiffness[0], hinge.stiffness[1], hinge.stiffness[2] + cubic]


class BreathingCrack(ModelEffect):
    """A crack near a link's root that opens on one side only: the second hinge is softer beyond a threshold angle."""

    id = "breathing_crack"
    at = ("link",)
    needs = frozenset({"boom"})
    table = {
        "loss": Parameter("1", 0.0, 0.0, 0.9, 0.4),
        "threshold": Parameter("rad", 0.0, -0.02, 0.0, 0.002),
    }
    confused_with = ("link_stiffness", "hydraulic_compliance")

    @classmethod
    def allowed(cls, sites: Sequence[Site]) -> tuple[Site, ...]:
        return tuple(site for site in super().allowed(sites) if site.location["link"] != 5)

    def edit(self, spec: mujoco.MjSpec, machine: Machine) -> None:
        hinge = link_hinges(spec, int(self.location["link"]), "v")[1]
        lost = self.values["loss"] * hinge.stiffness[0]
        hinge.stiffness = [hinge.stiffness[0] - lost, *hinge.stiffness[1:]]
        faces = spec.add_tendon(name="crack")
        faces.wrap_joint(hinge.name, 1.0)
        faces.springlength = [-FAR, self.values["threshold"]]
        faces.stiffness[0] = lost


class MovingSlug(ForceEffect):
    """Concrete that comes and goes at the tip with the strokes: a square wave of weight, half of the time there."""

    id = "moving_slug"
    needs = frozenset({"boom"})
    table = {
        "mass": Parameter("kg", 0.0, 0.0, 500.0, 30.0),
        "period": Parameter("s", 4.0, 1.0, 20.0, 1.0),
        "phase": Parameter("rad", 0.0, -20.0, 20.0, 0.5),
    }
    confused_with = ("pump_pulsation", "tip_payload")

    def force(self, motion: Motion) -> Mapping[str, Array]:
        there = np.sin(2 * np.pi * motion.time / self.values["period"] + self.values["phase"]) > 0
        weight = -self.values["mass"] * motion.boom.gravity * there
        return {"tip": weight[:, None] * np.array([0.0, 0.0, 1.0])}


class MistrackedMarker(OutputEffect):
    """A tracker that takes something else for a marker from some time on: the marker jumps and stays off."""

    id = "mistracked_marker"
    at = ("marker",)
    needs = frozenset({"boom"})
    table = {
        **{f"offset_{axis}": Parameter("m", 0.0, -5.0, 5.0, 0.2) for axis in "xyz"},
        "since": Parameter("s", 0.0, 0.0, 1e4, 5.0),
    }
    confused_with = ("marker_slip",)

    def observe(self, signals: Mapping[str, Signal], machine: Machine) -> Mapping[str, Signal]:
        markers, number = signals["markers"], int(self.location["marker"]) - 1
        points = markers.values.reshape(len(markers.time), -1, 3).copy()
        points[markers.time >= self.values["since"], number] += [self.values[f"offset_{axis}"] for axis in "xyz"]
        return {"markers": replace(markers, values=points.reshape(markers.values.shape))}


class CameraScale(OutputEffect):
    """Cameras calibrated with a wrong length: all positions are too large by a share."""

    id = "camera_scale"
    needs = frozenset({"boom"})
    table = {"share": Parameter("1", 0.0, -0.2, 0.2, 0.006)}
    confused_with = ("camera_pose",)

    def observe(self, signals: Mapping[str, Signal], machine: Machine) -> Mapping[str, Signal]:
        return {"markers": replace(signals["markers"], values=signals["markers"].values * (1 + self.values["share"]))}


class SluggishImu(OutputEffect):
    """An IMU behind a low-pass filter of first order that no data sheet mentions."""

    id = "sluggish_imu"
    at = ("link",)
    needs = frozenset({"boom"})
    table = {"time_constant": Parameter("s", 0.0, 0.0, 5.0, 0.25)}
    confused_with = ("clock_offset", "structural_damping")

    def observe(self, signals: Mapping[str, Signal], machine: Machine) -> Mapping[str, Signal]:
        names = [f"imu/link{self.location['link']}/{kind}" for kind in ("specific_force", "angular_rate")]
        return {name: self._late(signals[name]) for name in names if self.values["time_constant"]}

    def _late(self, signal: Signal) -> Signal:
        keep = np.exp(-(signal.time[1] - signal.time[0]) / self.values["time_constant"])
        late = lfilter([1 - keep], [1, -keep], signal.values - signal.values[0], axis=0)
        return replace(signal, values=signal.values[0] + late)


UNLISTED: Mapping[str, type[Effect]] = {
    kind.id: kind
    for kind in (
        HardeningLink,
        BreathingCrack,
        MovingSlug,
        MistrackedMarker,
        CameraScale,
        SluggishImu,
    )
}
