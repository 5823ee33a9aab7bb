"""A sensor whose clock is off."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from boom_mj.effects import OutputEffect, Parameter
from boom_mj.machine import Machine
from boom_mj.recording import Signal

STREAMS = {"imu": "imu/", "marker": "markers", "cylinder": "cylinder/"}


class ClockOffset(OutputEffect):
    """What a stream stamps with t was so at t - delay."""

    id = "clock_offset"
    at = ("stream",)
    needs = frozenset({"boom"})
    table = {"delay": Parameter("s", 0.0, -2.0, 2.0, 0.05)}
    confused_with = ("joint_play",)
    separating_experiment = "chirp_joint2"
    sizes = (-3.0, -1.0, -0.3, 0.3, 1.0, 3.0)

    def observe(self, signals: Mapping[str, Signal], machine: Machine) -> Mapping[str, Signal]:
        if self.values["delay"] == 0:
            return {}
        stream = STREAMS[str(self.location["stream"])]
        return {name: self._late(signal) for name, signal in signals.items() if name.startswith(stream)}

    def _late(self, signal: Signal) -> Signal:
        earlier = signal.time - self.values["delay"]
        return replace(signal, values=np.stack([np.interp(earlier, signal.time, c) for c in signal.values.T], axis=1))
