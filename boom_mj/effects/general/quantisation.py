"""Resolution of a channel."""

from collections.abc import Mapping

import numpy as np

from boom_mj.effects.effect import Array, Parameter
from boom_mj.effects.general_effect import ChannelEffect, Typical


class Quantisation(ChannelEffect):
    """Resolution of a channel: the log holds multiples of a step."""

    id = "quantisation"
    needs = frozenset({"compared", "motion"})
    sizes = (0.3, 1.0, 3.0)
    confused_with = ("sensor_offset",)
    told_by = "slow motion"

    @classmethod
    def sized(cls, typical: Typical) -> Mapping[str, Parameter]:
        return {"step": Parameter(typical.unit, 0.0, 0.0, typical.value, 0.05 * typical.value)}

    def read(self, time: Array, true: Array) -> Array:
        return np.round(true / self.values["step"]) * self.values["step"] if self.values["step"] else true

    def true(self, time: Array, logged: Array) -> Array:
        return logged
