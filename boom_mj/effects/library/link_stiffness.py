"""A link softer or stiffer than its drawing."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import mujoco

from boom_mj.effects import ModelEffect, Parameter, Site
from boom_mj.effects.spec_edits import chain, link_hinges


class LinkStiffness(ModelEffect):
    """Every modulus of one deformation of a boom's link times a factor, its Kelvin-Voigt damping with it.

    In any other MJCF machine: of all sprung joints LINK/1, LINK/2, ... that stand for the bending of a flexible link;
    their damping stays.
    """

    id = "link_stiffness"
    at = ("link", "axis")
    needs = frozenset({"elastic"})
    confused_with = (
        "hydraulic_compliance",
        "base_compliance",
        "slew_compliance",
        "body_mass",
        "payload",
        "link_density",
        "tip_payload",
        "relaxing_stiffness",
    )
    separating_experiment = "release_bow_vertical"

    @classmethod
    def allowed(cls, sites: Sequence[Site]) -> tuple[Site, ...]:
        return tuple(site for site in sites if site.keys in (("link", "axis"), ("link",)) and cls.needs <= site.tags)

    @classmethod
    def parameters(cls, site: Site) -> Mapping[str, Parameter]:
        if "mjcf" in site.tags:
            return {"factor": Parameter("1", 1.0, 0.05, 20.0, 0.1, likely=(0.5, 2.0))}  # moduli of a batch
        return {"factor": Parameter("1", 1.0, 0.2, 5.0, -0.1)}

    @classmethod
    def screening(cls, site: Site, lines_hz: Sequence[float] = ()) -> list[list[dict[str, float]]]:
        """Softer and, of a boom, stiffer."""
        ((name, parameter),) = cls.parameters(site).items()
        return [[{name: parameter.value(size)}] for size in ((1.0,) if "mjcf" in site.tags else (1.0, -1.0))]

    def edit(self, spec: mujoco.MjSpec, machine: Any) -> None:
        factor = self.values["factor"]
        for hinge in self._hinges(spec):
            hinge.stiffness = hinge.stiffness * factor
            if "boom" in self.site.tags:
                hinge.damping = hinge.damping * factor

    def _hinges(self, spec: mujoco.MjSpec) -> Iterator[mujoco.MjsJoint]:
        if "axis" in self.location:
            yield from link_hinges(spec, int(self.location["link"]), str(self.location["axis"]))
        else:
            yield from chain(spec, str(self.location["link"]))
