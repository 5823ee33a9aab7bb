"""Resolution of a channel."""

from collections.abc import Mapping

import numpy as np

from boom_mj.effects import Array, ChannelEffect, Parameter, Site


class Quantisation(ChannelEffect):
    """Resolution of a channel: the log holds multiples of a step."""

    id = "quantisation"
    needs = frozenset({"mjcf", "compared", "motion"})
    sizes = (0.3, 1.0, 3.0)
    confused_with = ("sensor_offset",)
    separating_experiment = "slow motion"

    @classmethod
    def parameters(cls, site: Site) -> Mapping[str, Parameter]:
        return {"step": Parameter(site.unit, 0.0, 0.0, site.value, 0.05 * site.value)}

    def apply(self, time: Array, true: Array) -> Array:
        return np.round(true / self.values["step"]) * self.values["step"] if self.values["step"] else true

    def invert(self, time: Array, read: Array) -> Array:
        return read
