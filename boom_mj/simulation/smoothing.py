"""Joint angles of a log, made smooth enough to be differentiated twice.

A 50 Hz angle sensor with 0.02 deg of noise says nothing of accelerations: differentiated, it would shake the boom.
What is known besides is that a joint stands still most of the time. So stretches of rest are found first - where a line
through a window of samples has a slope within its own noise - and held at their mean; between them the angle minimises

    sum (y - q)^2 / sigma^2 + weight * sum (d^3 q)^2,

Whittaker's smoother with a third difference (as little jerk as the samples allow), its weight such that what it takes
away has the size of the sensor's noise.
"""

import numpy as np
from scipy.interpolate import make_interp_spline
from scipy.ndimage import binary_erosion
from scipy.optimize import brentq
from scipy.signal import savgol_filter
from scipy.sparse import diags_array
from scipy.sparse.linalg import spsolve

Array = np.ndarray
WINDOW = 0.8  # s, over which rest shows
SLOPE_SIGMAS = 5.0
REST_WEIGHT = 1e6  # of a rest's mean against a single sample


def smooth_angles(time: Array, angles: Array, noise: float, at: Array) -> Array:
    """Smooth joint angles, (m, k), rad, at new times.

    Args:
        time: sample times, (n,), s; nearly even.
        angles: (n, k), rad.
        noise: standard deviation of the sensors, rad.
        at: times wanted, (m,), s; beyond the samples the ends are held.
    """
    even = np.linspace(time[0], time[-1], len(time))
    smooth = [_smooth(np.interp(even, time, column), even[1] - even[0], noise) for column in angles.T]
    spline = make_interp_spline(even, np.stack(smooth, axis=1), k=5)
    return spline(np.clip(at, even[0], even[-1]))


def resting(values: Array, step: float, noise: float) -> Array:
    """Where a joint stands still, (n,) of bool."""
    half = max(2, round(WINDOW / step / 2))
    width, lag = min(2 * half + 1, len(values)), np.arange(-half, half + 1)
    slope = savgol_filter(values, width, polyorder=1, deriv=1)  # of a line through every window, per sample
    still = np.abs(slope) < SLOPE_SIGMAS * noise / np.sqrt(lag @ lag)
    return binary_erosion(still, iterations=half // 2, border_value=1)


def _smooth(values: Array, step: float, noise: float) -> Array:
    n, still = len(values), resting(values, step, noise)
    edges = np.flatnonzero(np.diff(np.concatenate([[0], still.astype(int), [0]])))
    target, weight = values.copy(), np.ones(n)
    for start, stop in edges.reshape(-1, 2):
        target[start:stop], weight[start:stop] = values[start:stop].mean(), REST_WEIGHT
    if still.all():
        return target
    third = diags_array([-1.0, 3.0, -3.0, 1.0], offsets=[0, 1, 2, 3], shape=(n - 3, n))
    penalty = (third.T @ third).tocsc()

    def solve(log_weight: float) -> Array:
        return spsolve((diags_array(weight) + 10**log_weight * penalty).tocsc(), weight * target)

    def excess(log_weight: float) -> float:
        moving = ~still
        return float(np.sqrt(np.mean((values - solve(log_weight))[moving] ** 2)) - noise)

    low, high = -2.0, 9.0
    if excess(low) > 0 or excess(high) < 0:
        return solve(low if excess(low) > 0 else high)
    return solve(brentq(excess, low, high, xtol=0.05))
