"""A decaying vibration: stationary values, frequencies and damping ratios of many channels at once.

Every channel is y(t) = c + sum_m e^(-zeta_m w_m t) (a_m cos w'_m t + b_m sin w'_m t) with frequencies and damping
ratios that all channels share: for given ones c, a, b follow linearly, so that few numbers are searched for.
"""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

Array = np.ndarray
SCAN = np.linspace(0.7, 1.4, 71)  # times the expected frequency
BOUNDS = np.log([0.5, 2.0]), np.log([1e-3, 0.5])  # of a frequency over the scanned one, of a damping ratio


@dataclass(frozen=True)
class Decay:
    """Modes of a decay, slowest first, with standard deviations.

    Attributes:
        frequency: undamped, Hz, (m,).
        damping_ratio: (m,).
        frequency_deviation, damping_deviation: of their logarithms, (m,).
        share: of the scatter about the constants that the modes take, 0 to 1.
        constant: where every channel comes to rest, (k,).
        constant_deviation: (k,).
    """

    frequency: Array
    damping_ratio: Array
    frequency_deviation: Array
    damping_deviation: Array
    share: float
    constant: Array
    constant_deviation: Array


def fit_decay(time: Array, values: Array, noise: Array, expected: Array, damping_ratio: float) -> Decay:
    """Fit modes near expected frequencies, the first of them the strongest.

    Args:
        time: (n,), s, from the begin of the decay.
        values: (n, k); channels with a NaN get no constant.
        noise: standard deviations, (n, k).
        expected: frequencies, Hz, (m,).
        damping_ratio: to begin with.
    """
    whole = np.isfinite(values).all(axis=0)
    level = np.sqrt(np.mean(noise[:, whole] ** 2, axis=0))
    white = values[:, whole] / level

    def left(shape: Array) -> Array:
        basis = np.linalg.qr(_basis(time, shape))[0]
        return white - basis @ (basis.T @ white)

    shape = np.zeros((0, 2))  # rows (ln frequency, ln damping ratio)
    for start in expected:
        tried = [np.vstack([shape, [np.log(start * scale), np.log(damping_ratio)]]) for scale in SCAN]
        shape = min(tried, key=lambda trial: float(np.sum(left(trial) ** 2)))
        low = np.stack([shape[:, 0] + BOUNDS[0][0], np.full(len(shape), BOUNDS[1][0])], axis=1).ravel()
        high = np.stack([shape[:, 0] + BOUNDS[0][1], np.full(len(shape), BOUNDS[1][1])], axis=1).ravel()
        begin = np.clip(shape.ravel(), low + 1e-9, high - 1e-9)
        found = least_squares(lambda u: left(u.reshape(-1, 2)).ravel(), begin, bounds=(low, high), x_scale=0.01)
        shape = found.x.reshape(-1, 2)
    spread = np.sqrt(max(1.0, 2 * found.cost / white.size))
    deviation = spread * np.sqrt(np.diag(np.linalg.pinv(found.jac.T @ found.jac)))
    constant, error = np.full(values.shape[1], np.nan), np.full(values.shape[1], np.nan)
    basis = _basis(time, shape)
    constant[whole] = np.linalg.lstsq(basis, white)[0][0] * level
    scatter = np.maximum(1.0, np.sqrt(np.mean(left(shape) ** 2, axis=0)))
    error[whole] = scatter * level * np.sqrt(np.linalg.inv(basis.T @ basis)[0, 0])
    order = np.argsort(shape[:, 0])
    (frequency, ratio), errors = np.exp(shape[order].T), deviation.reshape(-1, 2)[order].T
    share = 1 - np.sum(left(shape) ** 2) / np.sum((white - white.mean(axis=0)) ** 2)
    return Decay(frequency, ratio, errors[0], errors[1], float(share), constant, error)


def _basis(time: Array, shape: Array) -> Array:
    """Columns 1, and cosine and sine of every mode, (n, 1 + 2 m)."""
    columns = [np.ones_like(time)]
    for frequency, ratio in np.exp(shape):
        omega = 2 * np.pi * frequency
        phase = omega * np.sqrt(1 - ratio**2) * time
        columns += [np.exp(-ratio * omega * time) * wave for wave in (np.cos(phase), np.sin(phase))]
    return np.stack(columns, axis=1)
