"""Frequencies that stand out of what is left, for effects that have a period."""

import numpy as np
from scipy.special import gammaincc

from boom_mj.diagnosis.linearisation import Linearisation

Array = np.ndarray


def spectral_lines(model: Linearisation, residual: Array) -> list[float]:
    """Frequencies (Hz) that stand out of the whitened channels that listen, in every training recording.

    Of white noise a channel's power is exponentially distributed, their sum by a gamma distribution.
    """
    data, budget, powers = model.data, model.budget, []
    grid = np.arange(budget.line_low_hz, budget.line_high_hz, 0.005)
    for number, channel in enumerate(data.channels):
        if channel.signal == model.facts.line_signal and channel.recording in data.trained:
            part = residual[data.stretch(number)]
            part, taper = part - part.mean(), np.hanning(len(part))
            phase = np.exp(-2j * np.pi * grid[:, None] * channel.time[None, :])
            mean = (part @ part + 1) * np.mean(taper**2)
            powers.append(np.abs(phase @ (part * taper)) ** 2 / mean)
    if not powers:
        return []
    total = np.sum(powers, axis=0)
    peaks = np.flatnonzero((total[1:-1] > total[:-2]) & (total[1:-1] >= total[2:])) + 1
    peaks = peaks[gammaincc(len(powers), total[peaks]) * len(peaks) < budget.line_chance]
    return [float(grid[k]) for k in peaks[np.argsort(-total[peaks])][: budget.lines]]
