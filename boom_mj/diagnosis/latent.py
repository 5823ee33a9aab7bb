"""What latent inputs of effects do in every recording: few units are simulated.

In between the machine hardly changes, and a response is that of the latest unit, later.
"""

from collections.abc import Sequence
from concurrent.futures import Future
from dataclasses import dataclass

import numpy as np

from boom_mj.effects import Effect
from boom_mj.estimation.latent_input import KNOT_S, LatentInput, estimate_latent, make_part
from boom_mj.estimation.noise import NoiseModel
from boom_mj.systems.predictor import Predictor
from boom_mj.systems.system import Hypothesis

Array = np.ndarray
STRIDE = 0.1  # rad, that a joint moves between units that are simulated


def latent_input_of(
    predictor: Predictor, effects: Hypothesis, noise: NoiseModel, residual: Array, recordings: Sequence[int]
) -> LatentInput | None:
    """Latent input of the first effect that has one, None where none has.

    Args:
        noise: that whitens, without latent inputs and blur.
        residual: whitened, from which the strength is estimated, (N,).
        recordings: those that count.
    """
    hidden = next((e for e in effects if e.basis(0.0)), None)
    if hidden is None:
        return None
    data = predictor.data
    begun = [UnitResponses.begin(predictor, effects, hidden, k) for k in recordings]  # all, before one is awaited
    parts = [make_part(data.rows(one.index), one.whitened(predictor, noise), one.knots) for one in begun]
    trained = [part for part in parts if data.train[part.rows].any()]
    return estimate_latent(parts, trained, residual, data.correlation_s, hidden.latent_limit)


def units_of(predictor: Predictor, index: int) -> tuple[Array, Array]:
    """Times of all units of a recording, (k,), s, and which are simulated.

    Those are where a joint has moved a STRIDE, or a motion or a load has ended: a released boom swings otherwise.
    """
    data = predictor.data
    knots, timeline = np.arange(KNOT_S, data.duration(index), KNOT_S), predictor.system.timeline(data.recordings[index])
    motion, phases = timeline.coordinates(knots), timeline.phases()
    phase = phases[np.minimum((knots / data.block_s).astype(int), len(phases) - 1)]
    ended, chosen = np.char.startswith(phase, "after") & (phase != np.roll(phase, 1)), [0]
    for k, pose in enumerate(motion):
        if np.max(np.abs(pose - motion[chosen[-1]])) > STRIDE or (k and ended[k]):
            chosen.append(k)
    return knots, np.array(chosen)


@dataclass(frozen=True)
class UnitResponses:
    """Responses to units that are being simulated.

    Attributes:
        index: of the recording.
        knots: times of all units, s.
        chosen: numbers of those that are simulated.
        awaited: the simulation without a unit and those with one.
    """

    index: int
    knots: Array
    chosen: Array
    awaited: tuple[Future[Array], ...]

    @classmethod
    def begin(cls, predictor: Predictor, effects: Hypothesis, hidden: Effect, index: int) -> "UnitResponses":
        """Of the one among some effects that has a latent input."""
        knots, chosen = units_of(predictor, index)
        rest, level = tuple(e for e in effects if e is not hidden), predictor.system.facts.fidelity.coarse
        units = [(*rest, unit) for k in chosen if (unit := hidden.basis(knots[k]))]
        awaited = tuple(predictor.begin(hypothesis, level, index, gapless=True) for hypothesis in (effects, *units))
        return cls(index, knots, chosen, awaited)

    def whitened(self, predictor: Predictor, noise: NoiseModel) -> Array:
        """To all units, (n, k)."""
        data = predictor.data
        without, *found = (future.result() for future in self.awaited)
        latest = np.searchsorted(self.chosen, np.arange(len(self.knots)), "right") - 1
        late = np.round((self.knots - self.knots[self.chosen[latest]]) / data.block_s).astype(int)
        changes = np.nan_to_num([unit - without for unit in found])
        parts, first = [], 0
        for channel in data.of(self.index):
            own = changes[:, first : (first := first + channel.blocks[-1] + 1)]
            before = channel.blocks[:, None] - late
            parts.append(np.where(before >= 0, own[latest, np.maximum(before, 0)], 0.0).astype(np.float32))
        return noise.whitened(data.rows(self.index), np.concatenate(parts))
