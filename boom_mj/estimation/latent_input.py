"""Courses in time that no log tells, such as the gusts of a wind: every recording tells its own by all of its channels.

With L the whitened responses to pulses KNOT apart and Q the covariance of a first-order process, what is left when the
rest is right has the covariance 1 + s^2 L Q L^T. Its strength s is the likeliest in training, and whitening by it takes
out of a residual what such a course explains. Few pulses are simulated: in between boom and pose hardly change, and a
response is that of the latest pulse, later.
"""

from collections.abc import Callable, Sequence
from concurrent.futures import Future
from dataclasses import dataclass

import numpy as np
from scipy.linalg import cholesky, eigh

from boom_mj.effects import Effect
from boom_mj.effects.effect import COURSE_TIME, KNOT
from boom_mj.systems.predictor import Campaign
from boom_mj.systems.system import Hypothesis

Array = np.ndarray
STRIDE = 0.1  # rad, that a joint moves between pulses that are simulated
LEAST = 1e-2  # variance of a mode at strength 1 that is worth keeping
STRENGTHS = np.logspace(-3, 1, 401)
STEADY = 0.6  # least steadiness
HEARD = 0.1  # of what windows tell of a course on average, below which one tells nothing
LIKELY = 1.92  # fall of the logarithm of the likelihood at the ends of a 95 % interval


@dataclass(frozen=True)
class Part:
    """What a course does in one recording.

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


@dataclass(frozen=True)
class Courses:
    """What courses do in all recordings.

    Attributes:
        strength, reach: standard deviation in pulses, and its 95 % interval.
        steadiness: median of the course's power in windows of time over its mean; about 1 for what never rests.
    """

    parts: tuple[Part, ...]
    strength: float
    reach: tuple[float, float]
    steadiness: float

    def without(self, white: Array) -> Array:
        """(1 + s^2 L Q L^T)^(-1/2) times a whitened vector, (N,)."""
        out = white.copy()
        for part in self.parts:
            share = 1 - 1 / np.sqrt(1 + self.strength**2 * part.power)
            out[part.rows] -= part.does(share * part.felt(white))
        return out


NONE = Courses((), 0.0, (0.0, 0.0), 0.0)


def courses_of(
    campaign: Campaign,
    effects: Hypothesis,
    white: Callable[[slice, Array], Array],
    residual: Array,
    recordings: Sequence[int],
) -> Courses | None:
    """Courses of the first effect that has one, None where none has; NONE if what they would be is not what they are.

    Whatever vibrates could be pushed so. A course that rests, or is stronger than its effect allows, is none.

    Args:
        white: whitens columns (n, k) of the entries that a slice names.
        residual: whitened, from which the strength is learnt, (N,).
        recordings: those that count.
    """
    hidden = next((e for e in effects if e.pulse(0.0)), None)
    if hidden is None:
        return None
    plans = [_Plan.of(campaign, effects, hidden, k) for k in recordings]  # all begin before one is awaited
    parts = [plan.part(white) for plan in plans]
    learnt = [part for part in parts if campaign.train[part.rows].any()]
    power, felt = (np.concatenate(both) for both in zip(*((p.power, p.felt(residual)) for p in learnt)))
    spread = 1 + STRENGTHS[:, None] ** 2 * power
    likelihood = 0.5 * np.sum(felt**2 * (1 - 1 / spread) - np.log(spread), axis=1)
    likely, strength = STRENGTHS[likelihood > likelihood.max() - LIKELY], float(STRENGTHS[np.argmax(likelihood)])
    steadiness = _steadiness(learnt, strength, residual, round(campaign.subject.window / KNOT))
    if not steadiness >= STEADY or strength > hidden.strongest:
        return NONE
    return Courses(tuple(parts), strength, (float(likely[0]), float(likely[-1])), steadiness)


def _steadiness(parts: Sequence[Part], strength: float, residual: Array, window: int) -> float:
    """See `Courses`; power of the likeliest innovations over what is expected of them, by windows of so many knots."""
    found, expected = [], []
    for part in parts:
        gain = strength**2 * part.power / (1 + strength**2 * part.power)
        innovations = part.turn @ (gain / (strength * np.sqrt(part.power)) * part.felt(residual))
        begins = np.arange(0, len(innovations), window)
        found.append(np.add.reduceat(innovations**2, begins))
        expected.append(np.add.reduceat(part.turn**2 @ gain, begins))
    power, told = np.concatenate(found), np.concatenate(expected)
    heard = told > HEARD * told.mean()
    return float(np.median(power[heard] / told[heard]) * told.sum() / max(power.sum(), 1e-12))


@dataclass(frozen=True)
class _Plan:
    """Pulses that are being simulated.

    Attributes:
        rows: of the recording in the long vector.
        blocks: numbers of those that each of its channels has, (n,) of int.
        knots: times of all pulses, s.
        chosen: numbers of those that are simulated.
        awaited: the simulation without a pulse and those with one.
    """

    campaign: Campaign
    rows: slice
    blocks: tuple[Array, ...]
    knots: Array
    chosen: Array
    awaited: tuple[Future[Array], ...]

    @classmethod
    def of(cls, campaign: Campaign, effects: Hypothesis, hidden: Effect, index: int) -> "_Plan":
        knots = np.arange(KNOT, campaign.duration(index), KNOT)
        motion, chosen = campaign.subject.motion(campaign.recordings[index], knots), [0]
        for k, pose in enumerate(motion):
            if np.max(np.abs(pose - motion[chosen[-1]])) > STRIDE:
                chosen.append(k)
        rest, level = tuple(e for e in effects if e is not hidden), campaign.subject.fidelity.coarse
        pulsed = [(*rest, pulse) for k in chosen if (pulse := hidden.pulse(knots[k]))]
        awaited = tuple(campaign.begin(hypothesis, level, index, gapless=True) for hypothesis in (effects, *pulsed))
        own = [k for k, channel in enumerate(campaign.channels) if channel.recording == index]
        blocks = tuple(campaign.channels[k].blocks for k in own)
        rows = slice(campaign.stretch(own[0]).start, campaign.stretch(own[-1]).stop)
        return cls(campaign, rows, blocks, knots, np.array(chosen), awaited)

    def part(self, white: Callable[[slice, Array], Array]) -> Part:
        """Responses to all pulses."""
        without, *found = (future.result() for future in self.awaited)
        latest = np.searchsorted(self.chosen, np.arange(len(self.knots)), "right") - 1
        late = np.round((self.knots - self.knots[self.chosen[latest]]) / self.campaign.subject.block).astype(int)
        changes = np.nan_to_num([pulsed - without for pulsed in found])
        parts, first = [], 0
        for blocks in self.blocks:
            own = changes[:, first : (first := first + blocks[-1] + 1)]
            before = blocks[:, None] - late
            parts.append(np.where(before >= 0, own[latest, np.maximum(before, 0)], 0.0).astype(np.float32))
        responses = white(self.rows, np.concatenate(parts))
        root = cholesky(np.exp(-np.abs(self.knots[:, None] - self.knots) / COURSE_TIME), lower=True)
        power, turn = eigh(root.T @ (responses.T @ responses) @ root)
        kept = power > LEAST
        power, turn = power[kept], turn[:, kept]
        return Part(self.rows, responses, root @ turn / np.sqrt(power), turn, power)
