"""From the machine file to what was recorded in three steps, and the gap of every channel at each of them.

1. Data sheet: the nominal machine, the file as it is. 2. As built: with nuisances as they were estimated. 3. With
causes: with the effects of the best explanation, too. A channel's gap is here what `replay` prints with as many hinges:
root mean square of measured - simulated over the noise of its sensor, all samples counted.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from boom_mj.diagnosis.conclusion import Diagnosis
from boom_mj.diagnosis.predictions import nominal_predictor, simulated_recording, steps
from boom_mj.effects import Effect
from boom_mj.errors import BoomError
from boom_mj.estimation.bootstrap import mean_over
from boom_mj.estimation.intervals import Z95
from boom_mj.recording import Recording
from boom_mj.replay import Group, compare
from boom_mj.systems.system import Nuisance

Array = np.ndarray


@dataclass(frozen=True)
class ChannelSteps:
    """A channel group of one recording.

    Attributes:
        log: name of the recording.
        channel: name of the group, such as "imu/link5/specific_force/y".
        data_sheet, as_built, with_causes: rms of measured - simulated over noise.
        uncertainty: of with_causes, 95 %, by windows within which residuals are correlated.
    """

    log: str
    channel: str
    data_sheet: float
    as_built: float
    with_causes: float
    uncertainty: float

    @property
    def worse(self) -> bool:
        """Whether the correction makes it worse by more than its uncertainty."""
        return self.with_causes - self.data_sheet > self.uncertainty


def channel_steps(found: Diagnosis, names: Sequence[str] = ()) -> list[ChannelSteps]:
    """Of all recordings that can be simulated at every step.

    Args:
        names: of the recordings; their own if left out.
    """
    predictor, hypotheses = nominal_predictor(found), steps(found).values()
    rows: list[ChannelSteps] = []
    for index, log in enumerate(found.model.data.recordings):
        try:
            recordings = [simulated_recording(predictor, effects, index) for effects in hypotheses]
        except BoomError:
            continue
        rows += _compared(found, log, recordings, names[index] if index < len(names) else log.name)
    return rows


def _compared(found: Diagnosis, log: Recording, recordings: Sequence[Recording], name: str) -> Iterator[ChannelSteps]:
    system, noise = found.model.system, _noise(found)
    compared = [compare(log, one, noise, lambda *at: system.channel(*at).group) for one in recordings]
    for groups in zip(*compared):
        before, built, after = (group.ratio for group in groups)
        if np.isfinite([before, built, after]).all():
            uncertainty = _uncertainty(groups[-1], log, recordings[-1], found.model.data.correlation_s)
            yield ChannelSteps(name, groups[0].name, before, built, after, uncertainty)


def _uncertainty(group: Group, log: Recording, simulated: Recording, window_s: float) -> float:
    """Of a group's ratio, 95 %: that of its square over twice the ratio."""
    columns, measured = list(group.columns), log[group.signal]
    squares = ((measured.values - simulated[group.signal].values)[:, columns] / group.noise) ** 2  # (m, k)
    windows = np.floor((measured.time - measured.time[0]) / window_s).astype(int)
    seen = np.isfinite(squares)
    _, error = mean_over(np.broadcast_to(windows[:, None], seen.shape)[seen], squares[seen])
    return Z95 * error / (2 * group.ratio)


def _noise(found: Diagnosis) -> dict[str, Array]:
    """Of the sensors' samples, by signal, as the machine file says; where it says nothing, as the recordings do."""
    noise = {name: np.array(level, float) for name, level in found.model.facts.noise.items()}
    for channel in found.model.data.channels:
        level = noise[channel.signal]
        level[channel.column] = level[channel.column] or channel.noise
    return noise


@dataclass(frozen=True)
class NuisanceSize:
    """A parameter of a nuisance.

    Attributes:
        value: as it was estimated, in `unit`.
        neutral, deviation: its prior.
    """

    effect: Effect
    parameter: str
    value: float
    neutral: float
    deviation: float


def nuisance_sizes(effects: Iterable[Effect], nuisances: Iterable[Nuisance]) -> list[NuisanceSize]:
    """Estimated nuisances, each with its prior: of one that several act on, all of them together."""
    variance: dict[tuple, float] = {}
    for nuisance in nuisances:
        for whole in nuisance.hypothesis:
            for name, value in whole.values.items():
                part = nuisance.deviation * (value - whole.declared[name].neutral)
                variance[whole.cause, name] = variance.get((whole.cause, name), 0.0) + part**2
    return [
        NuisanceSize(effect, name, value, effect.declared[name].neutral, float(np.sqrt(variance[effect.cause, name])))
        for effect in effects
        for name, value in effect.values.items()
        if variance.get((effect.cause, name))
    ]
