"""A spring that is softer at rest than in motion."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import mujoco

from boom_mj.effects import Array, ModelEffect, Values
from boom_mj.effects.parameter import Parameter
from boom_mj.effects.site import Site
from boom_mj.effects.spec_edits import add_relaxation, chain


class RelaxingStiffness(ModelEffect):
    """A spring that is softer at rest than in motion: rubber, silicone, glued and wooden parts.

    The standard linear solid: a share s of the model's stiffness k hangs on a dashpot and relaxes with the time T,

        f = -(1 - s) k q - s k (q - z),   T z' = q - z.

    Fast motion feels k, rest (1 - s) k; between them, at 1/T, it damps most. A stretch begins with z = 0.
    """

    id = "relaxing_stiffness"
    at = ("joint",)
    confused_with = ("link_stiffness", "joint_stiffness", "link_damping", "payload")
    separating_experiment = "free vibration, and a known static load"
    shapes = frozenset({"time"})

    @classmethod
    def allowed(cls, sites: Sequence[Site]) -> tuple[Site, ...]:
        """Sprung joints and flexible links of any MJCF machine."""
        mjcf = (site for site in sites if "mjcf" in site.tags)
        return tuple(
            site
            for site in mjcf
            if (site.keys == ("joint",) and "sprung" in site.tags)
            or (site.keys == ("link",) and "elastic" in site.tags)
        )

    @classmethod
    def parameters(cls, site: Site) -> Mapping[str, Parameter]:
        return {
            "share": Parameter("1", 0.0, 0.0, 0.9, 0.1, likely=(0.0, 0.5)),  # filled rubbers lose up to a half
            "time": Parameter("s", 0.1, 0.005, 100.0, 0.1),
        }

    def edit(self, spec: mujoco.MjSpec, machine: Any) -> None:
        if self.values["share"]:
            for joint in self._joints(spec):
                add_relaxation(spec, joint, self.values["share"], self.values["time"])

    @classmethod
    def screening(cls, site: Site, lines_hz: Sequence[float] = ()) -> list[list[dict[str, float]]]:
        return [[{"share": 0.1, "time": time}] for time in (0.02, 0.1, 0.5, 2.0)]

    @classmethod
    def combine(cls, site: Site, points: Sequence[Values], weights: Array) -> dict[str, float]:
        share = cls.parameters(site)["share"]
        return {"share": share.value(float(weights[0])), "time": points[0]["time"]}

    def _joints(self, spec: mujoco.MjSpec) -> Iterator[mujoco.MjsJoint]:
        if "joint" in self.location:
            yield spec.joint(str(self.location["joint"]))
        else:
            yield from chain(spec, str(self.location["link"]))
