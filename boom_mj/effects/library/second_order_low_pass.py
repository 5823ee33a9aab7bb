"""Second-order low-pass filter in a sensor's path."""

from collections.abc import Mapping

import numpy as np
from scipy.signal import bilinear_zpk, sosfilt, sosfilt_zi, zpk2sos

from boom_mj.effects import Array, ChannelEffect, Parameter, Site

BUTTERWORTH = 2**-0.5  # damping ratio of poles


class SecondOrderLowPass(ChannelEffect):
    """Second-order low-pass filter of Butterworth's kind in a sensor's path: y'' + sqrt(2) w y' + w^2 y = w^2 u.

    Amplifiers of strain gauges and anti-aliasing filters are such; slow motion comes late by sqrt(2)/w. The parameter
    is the time constant 1/w.
    """

    id = "second_order_low_pass"
    needs = frozenset({"mjcf", "motion", "compared"})
    sizes = (1.0, 4.0, 16.0)
    confused_with = ("low_pass", "sensor_delay", "link_damping")
    separating_experiment = "fast motion"

    @classmethod
    def parameters(cls, site: Site) -> Mapping[str, Parameter]:
        return {"time_constant": Parameter("s", 0.0, 0.0, 500 * site.step, 2 * site.step)}

    def apply(self, time: Array, true: Array) -> Array:
        constant = self.values["time_constant"]
        if constant <= 0 or len(time) < 2:
            return true
        poles = [(-BUTTERWORTH + 1j * BUTTERWORTH) / constant, (-BUTTERWORTH - 1j * BUTTERWORTH) / constant]
        sections = zpk2sos(*bilinear_zpk([], poles, constant**-2, 1 / (time[1] - time[0])))
        return sosfilt(sections, true, zi=sosfilt_zi(sections) * true[0])[0]

    def invert(self, time: Array, read: Array) -> Array:
        """By differences: what a filter has taken from fast motion does not come back."""
        constant = self.values["time_constant"]
        if constant <= 0 or len(time) < 2:
            return read
        rate = np.gradient(read, time)
        return read + constant / BUTTERWORTH * rate + constant**2 * np.gradient(rate, time)
