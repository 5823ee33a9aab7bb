"""Inputs in time that no log tells, such as the gusts of a wind: every recording tells its own by all of its channels.

With L the whitened responses to units of such an input KNOT_S apart and Q the covariance of a first-order process, what
is left when the rest is right has the covariance 1 + s^2 L Q L^T. Its strength s is the likeliest in training, and
whitening by it takes out of a residual what such an input explains.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import cholesky, eigh

Array = np.ndarray
KNOT_S = 0.1  # between the units of which a latent input is made
CORRELATION_S = 2.0  # of a latent input
LEAST = 1e-2  # variance of a mode at strength 1 that is worth keeping
STRENGTHS = np.logspace(-3, 1, 401)
STEADY = 0.6  # least steadiness of what is an input of its own: it never rests
HEARD = 0.1  # of what windows tell of an input on average, below which one tells nothing
LIKELY = 1.92  # fall of the log-likelihood at the ends of a 95 % interval: half the quantile of chi-square


@dataclass(frozen=True, eq=False)
class Part:
    """What a latent input does in one recording.

    Attributes:
        rows: its entries of the long vector.
        responses: L, (n, k).
        modes: L times this is orthonormal, (k, m).
        turn: innovations of the process that make up each mode, orthonormal, (k, m).
        power: variance of each mode at strength 1, (m,).
    """

    rows: slice
    responses: Array
    modes: Array
    turn: Array
    power: Array

    def felt(self, white: Array) -> Array:
        """What each mode has of a whitened vector (N,), (m,)."""
        return self.modes.T @ (self.responses.T @ white[self.rows].astype(self.responses.dtype))

    def does(self, modes: Array) -> Array:
        """What modes of given sizes (m,) do, (n,)."""
        return self.responses @ (self.modes @ modes).astype(self.responses.dtype)


@dataclass(frozen=True, eq=False)
class LatentInput:
    """What latent inputs do in all recordings.

    Attributes:
        strength, interval: standard deviation in units, and its 95 % interval.
        steadiness: median of the input's power in windows of time over its mean; about 1 for what never rests.
    """

    parts: tuple[Part, ...]
    strength: float
    interval: tuple[float, float]
    steadiness: float

    def without(self, white: Array) -> Array:
        """(1 + s^2 L Q L^T)^(-1/2) times a whitened vector, (N,)."""
        out = white.copy()
        for part in self.parts:
            share = 1 - 1 / np.sqrt(1 + self.strength**2 * part.power)
            out[part.rows] -= part.does(share * part.felt(white))
        return out


NONE = LatentInput((), 0.0, (0.0, 0.0), 0.0)


def make_part(rows: slice, responses: Array, knots_s: Array) -> Part:
    """The modes of whitened responses (n, k) to units at times (k,)."""
    root = cholesky(np.exp(-np.abs(knots_s[:, None] - knots_s) / CORRELATION_S), lower=True)
    power, turn = eigh(root.T @ (responses.T @ responses) @ root)
    kept = power > LEAST
    power, turn = power[kept], turn[:, kept]
    return Part(rows, responses, root @ turn / np.sqrt(power), turn, power)


def estimate_latent(
    parts: Sequence[Part], trained: Sequence[Part], residual: Array, window_s: float, limit: float
) -> LatentInput:
    """The likeliest latent input; NONE if what it would be is not what it is.

    Whatever vibrates could be pushed so. An input that rests, or is stronger than its effect allows, is none.

    Args:
        trained: those from which the strength is estimated.
        residual: whitened, (N,).
        limit: of the strength.
    """
    power, felt = (np.concatenate(both) for both in zip(*((p.power, p.felt(residual)) for p in trained)))
    likelihood = _log_likelihood(power, felt)
    likely, strength = STRENGTHS[likelihood > likelihood.max() - LIKELY], float(STRENGTHS[np.argmax(likelihood)])
    steadiness = _steadiness(trained, strength, residual, round(window_s / KNOT_S))
    if not steadiness >= STEADY or strength > limit:
        return NONE
    return LatentInput(tuple(parts), strength, (float(likely[0]), float(likely[-1])), steadiness)


def posterior(part: Part, residual: Array) -> tuple[Array, Array]:
    """Of an input of the likeliest strength in one recording: mean and standard deviation in units, (k,) each.

    Args:
        residual: whitened, (N,).
    """
    felt = part.felt(residual)
    square = STRENGTHS[np.argmax(_log_likelihood(part.power, felt))] ** 2
    gain = square * part.power / (1 + square * part.power)
    known = (part.modes**2 * part.power) @ gain
    return part.modes @ (gain * felt), np.sqrt(square * np.maximum(1 - known, 0))


def _log_likelihood(power: Array, felt: Array) -> Array:
    """Of all strengths, less that of none, by modes (m,)."""
    spread = 1 + STRENGTHS[:, None] ** 2 * power
    return 0.5 * np.sum(felt**2 * (1 - 1 / spread) - np.log(spread), axis=1)


def _steadiness(parts: Sequence[Part], strength: float, residual: Array, window: int) -> float:
    """See `LatentInput`; power of the likeliest innovations over what is expected, by windows of so many knots."""
    found, expected = [], []
    for part in parts:
        gain = strength**2 * part.power / (1 + strength**2 * part.power)
        innovations = part.turn @ (gain / (strength * np.sqrt(part.power)) * part.felt(residual))
        begins = np.arange(0, len(innovations), window)
        found.append(np.add.reduceat(innovations**2, begins))
        expected.append(np.add.reduceat(part.turn**2 @ gain, begins))
    power, informed = np.concatenate(found), np.concatenate(expected)
    heard = informed > HEARD * informed.mean()
    if not heard.any():
        return 0.0
    return float(np.median(power[heard] / informed[heard]) * informed.sum() / max(power.sum(), 1e-12))
