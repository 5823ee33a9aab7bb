"""Play and elasticity between a joint and the friction that it works against."""

from collections.abc import Mapping, Sequence
from typing import Any

import mujoco

from boom_mj.effects import Array, ModelEffect, Values
from boom_mj.effects.parameter import Parameter
from boom_mj.effects.site import Site
from boom_mj.effects.spec_edits import move_friction_behind

RIGID = 100.0  # half gaps that a rigid brake's friction would have to give


class FrictionBehindPlay(ModelEffect):
    """Play and elasticity between a joint and the friction that it works against, as of a band brake or a gripped seal.

    The model's dry friction F of the joint moves behind both: with s the place where the brake has slipped to,

        f = -k z,   z = q - s beyond the half gap g either way, 0 within;   s follows where |k z| would exceed F.

    A reversal unloads the spring by 2 F/k, crosses the gap 2 g without force, and loads the spring anew. It is a tendon
    JOINT/friction whose spring yields; dry friction that other effects add to the joint lies there, too.
    """

    id = "friction_behind_play"
    at = ("joint",)
    needs = frozenset({"mjcf", "rubbing"})
    confused_with = ("backlash", "series_compliance", "coulomb_friction")
    separating_experiment = "reversals of slow motions"

    @classmethod
    def parameters(cls, site: Site) -> Mapping[str, Parameter]:
        soft = site.value / site.span
        return {
            "half_gap": Parameter(
                site.unit, 0.0, 0.0, 0.5 * site.span, 0.01 * site.span,
                likely=(0.0, 0.1 * site.span),  # of a machine that still serves its motion
            ),
            "stiffness": Parameter(
                f"{site.force_unit}/{site.unit}", float("inf"), soft, float("inf"), 30 * soft, inverse=True
            ),
        }  # fmt: skip

    def edit(self, spec: mujoco.MjSpec, machine: Any) -> None:
        half_gap, stiffness = self.values["half_gap"], self.values["stiffness"]
        friction = float(spec.joint(str(self.location["joint"])).frictionloss)
        if friction and (half_gap or stiffness < float("inf")):
            stiffest = RIGID * friction / half_gap if half_gap else stiffness
            move_friction_behind(spec, str(self.location["joint"]), half_gap, min(stiffness, stiffest))

    @classmethod
    def screening(cls, site: Site, lines_hz: Sequence[float] = ()) -> list[list[dict[str, float]]]:
        """Both act together: small and large gaps, soft and stiff."""
        gap, spring = cls.parameters(site).values()
        return [
            [{"half_gap": size * gap.typical, "stiffness": share * spring.typical}]
            for size in (1.0, 4.0)
            for share in (0.3, 1.0, 3.0)
        ]

    @classmethod
    def combine(cls, site: Site, points: Sequence[Values], weights: Array) -> dict[str, float]:
        """The point itself: what it changes does not grow with its size."""
        return dict(points[0])
