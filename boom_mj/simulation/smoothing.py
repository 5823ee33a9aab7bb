"""Joint angles of a log, made smooth enough to be differentiated twice.

A 50 Hz angle sensor with 0.02 deg of noise says nothing of accelerations: differentiated, it would shake the boom.
What is known besides is that a joint mostly rests or turns evenly, and speeds up in between. So the angle is a quintic
spline q(t) with evenly spaced knots whose coefficients c minimise

    sum (y - q(t))^2 / sigma^2 + sum (d^3 c)^2 / s^2,

a penalised spline: the mean of a random jerk of standard deviation s, given the samples, as a Rauch-Tung-Striebel
smoother would find it. How large s is differs along the path and is estimated from it: s^2 = GAIN x local mean of
(d^3 c)^2, solved again until it stays. GAIN makes up for the variance that a mean lacks. Where a joint rests - where a
line through a window of samples has a slope within its own noise - every sample is the mean of the rest, but for the
share 1 - chance / drift by which a cubic finds more drift in it than chance has, as it does where a sensor's error
creeps while the joint turns: Breiman's garrote (1995), which lets a drift in without a jump as it grows.

Chosen by figures among smoothers that know less: docs/explanation/smoothing.md.
"""

import numpy as np
from numpy.polynomial.legendre import legvander
from scipy.interpolate import BSpline
from scipy.linalg import solveh_banded
from scipy.ndimage import binary_erosion, uniform_filter1d
from scipy.sparse import csr_array

Array = np.ndarray
DEGREE = 5
KNOTS = 0.05  # s, between knots
GAIN = 4.0
ROUNDS = 8  # until the jerk's size stays
FIRST_JERK, LEAST_JERK = np.radians(10.0), np.radians(0.05)  # rad/s^3; the first does not matter
LOCAL = 0.5  # s, over which jerk has one size
WINDOW = 0.8  # s, over which rest shows
SLOPE_SIGMAS, DRIFT = 5.0, 3  # of a slope or drift that is none; degree of a drift
NORMAL = 1.4826  # standard deviation over median absolute deviation


def smooth_angles(time: Array, angles: Array, noise: float, at: Array) -> Array:
    """Smooth joint angles, (m, k), rad, at new times.

    Args:
        time: sample times, (n,), s, increasing.
        angles: (n, k), rad.
        noise: standard deviation of the sensors, rad; a joint whose samples scatter more is believed less.
        at: times wanted, (m,), s; beyond the samples the ends are held.
    """
    count = max(4, int(np.ceil((time[-1] - time[0]) / KNOTS)))
    knots = time[0] + (time[-1] - time[0]) / count * np.arange(-DEGREE, count + DEGREE + 1)
    low, high = knots[DEGREE], knots[-DEGREE - 1]
    basis = BSpline.design_matrix(np.clip(time, low, high), knots, DEGREE)
    step = (time[-1] - time[0]) / (len(time) - 1)
    columns = []
    for samples in angles.T:
        sigma = max(noise, float(white_noise(samples)))
        columns.append(_coefficients(basis, _rested(samples, step, sigma), sigma, knots[1] - knots[0]))
    return BSpline(knots, np.stack(columns, axis=1), DEGREE)(np.clip(at, low, high))


def white_noise(values: Array) -> Array:
    """Standard deviation of what is white in evenly sampled channels, (k,) of (n, k), or of (n,).

    From second differences, which motion hardly moves, and their median, which a stretch of motion does not move.
    """
    return NORMAL * np.nanmedian(np.abs(np.diff(values, 2, axis=0)), axis=0) / np.sqrt(6)


def resting(values: Array, step: float, noise: float) -> Array:
    """Where a joint stands still, (n,) of bool."""
    half = min(max(2, round(WINDOW / step / 2)), (len(values) - 1) // 2)
    lag = np.arange(-half, half + 1)
    inner = np.correlate(values, lag / (lag @ lag), mode="valid")  # slope of a line through every window, per sample
    slope = np.pad(inner, half, mode="edge")
    still = np.abs(slope) < SLOPE_SIGMAS * noise / np.sqrt(lag @ lag)
    return binary_erosion(still, iterations=half // 2, border_value=1)


def _rested(samples: Array, step: float, noise: float) -> Array:
    """Samples with every rest at its mean, (n,)."""
    still, samples = resting(samples, step, noise), samples.copy()
    edges = np.flatnonzero(np.diff(np.concatenate([[0], still.astype(int), [0]])))
    for start, stop in edges.reshape(-1, 2):
        rest, drift = samples[start:stop], legvander(np.linspace(-1, 1, stop - start), DRIFT)
        beyond = rest - drift @ np.linalg.lstsq(drift, rest, rcond=None)[0]
        chance = (SLOPE_SIGMAS * noise) ** 2 / len(rest)
        drifts = 1 - chance / max(np.var(rest) - np.var(beyond), chance)
        samples[start:stop] = rest.mean() + drifts * (rest - rest.mean())
    return samples


def _coefficients(basis: csr_array, samples: Array, noise: float, spacing: float) -> Array:
    """Spline coefficients c, (m,)."""
    size, scale = basis.shape[1], spacing**3
    gram = basis.T @ basis / noise**2
    data = np.stack([np.pad(gram.diagonal(k), (k, 0)) for k in range(DEGREE, -1, -1)])  # upper bands
    jerk = np.full(size - 3, FIRST_JERK**2)
    for _ in range(ROUNDS):
        bands = data.copy()
        bands[-4:] += third_difference_bands(1 / (jerk * scale**2))
        found = solveh_banded(bands, basis.T @ samples / noise**2)
        local = uniform_filter1d((np.diff(found, 3) / scale) ** 2, max(1, round(LOCAL / spacing)))
        jerk = GAIN * np.maximum(local, 0) + LEAST_JERK**2  # a running mean of squares may round below zero
    return found


def third_difference_bands(weight: Array) -> Array:
    """Upper bands of D^T diag(weight) D with D the third difference, (4, n + 3) of weight (n,)."""
    stencil, size = (-1.0, 3.0, -3.0, 1.0), len(weight)
    bands = np.zeros((4, size + 3))
    for i in range(4):
        for j in range(i, 4):
            bands[3 - j + i, j : j + size] += stencil[i] * stencil[j] * weight
    return bands
