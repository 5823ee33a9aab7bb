"""Numbers in another unit."""

from collections.abc import Iterator, Mapping

import numpy as np

from boom_mj.recording import QUANTITIES, UNITS
from boom_mj.replay.quality.beside import expected, pairs
from boom_mj.replay.quality.channels import own_noise, resolution
from boom_mj.replay.quality.check import Check, Found, Turn
from boom_mj.replay.quality.edits import DRIVE, mapped
from boom_mj.replay.quality.evidence import Evidence
from boom_mj.replay.quality.finding import Action, Repair

Array = np.ndarray
OFF = 6.0  # times: below it a wrong size may be a cause (a pressure sensor that reads five times too much)
NEAR = 1.35  # times a unit's factor
POWERS = {f"1e{k:+d}": 10.0**k for k in (-6, -5, -4, -3, -2, -1, 1, 2, 3, 4, 5, 6)}
SLOPE, AWAY = np.radians(1.0), np.radians(3.0)  # of a command, from which on its slope, its size tell


class JointUnit(Check):
    """A joint angle that is its command times the factor of a unit.

    By its slope where the command moves, by its size where it is away from zero, by its noise elsewhere.
    """

    kind = "unit"
    turn = Turn.JOINT_UNITS

    def look(self, evidence: Evidence) -> Iterator[Found]:
        for column in range(len(QUANTITIES[DRIVE].channels)):
            scales = {}
            for index in evidence.indices:
                should = expected(evidence, index, DRIVE)
                if should is not None:
                    values = evidence.recordings[index][DRIVE].values[:, column]
                    noise = evidence.noise(DRIVE)[column]
                    scales[index] = _joint_scale(values, should[:, column], noise)
            yield from _wrong(evidence, DRIVE, scales, column)


class Unit(Check):
    """A signal that is as many times too large or too small as a unit or a power of ten is, and its noise with it."""

    kind = "unit"
    turn = Turn.UNITS

    def look(self, evidence: Evidence) -> Iterator[Found]:
        names = dict.fromkeys(name for k in evidence.indices for name in evidence.measured(k) if name != DRIVE)
        for name in names:
            scales: dict[int, Array] = {}
            for index, pair in pairs(evidence, name):
                if name.endswith("angular_rate"):  # rests about zero
                    pair = pair.moving
                square = np.nanmean(pair.measured**2, axis=0)
                values = evidence.recordings[index][name].values.T
                noise = [_noise(column, level) for column, level in zip(values, evidence.noise(name))]
                if name.startswith("cylinder"):
                    scale = np.sqrt(square / (pair.power + 1))
                else:
                    scale = np.full(len(square), np.sqrt(np.nansum(square) / np.sum(pair.power + 1)))
                    noise = [float(np.median(noise))] * len(square)
                scales[index] = np.array([s if _scattered(s, ratio) else 1.0 for s, ratio in zip(scale, noise)])
            if name.startswith("cylinder"):
                for column in range(len(QUANTITIES[name].channels)):
                    yield from _wrong(evidence, name, {k: s[column] for k, s in scales.items()}, column)
            else:
                yield from _wrong(evidence, name, {k: float(s[0]) for k, s in scales.items()})


def _noise(values: Array, expected_noise: float) -> float:
    """How many times the noise that it should have a channel has; 0 where its steps hide it."""
    own = own_noise(values)
    return own / expected_noise if own and resolution(values) < own else 0.0


def _scattered(scale: float, noise: float) -> bool:
    """Whether noise is as wrong as the signal, as it is in another unit; a load that nobody knows leaves it alone."""
    return not noise or abs(np.log(noise / scale)) < abs(np.log(noise))


def _joint_scale(values: Array, command: Array, noise: float) -> float:
    if np.ptp(command) > SLOPE:
        about = command - command.mean()
        return float(np.abs(about @ (values - values.mean())) / (about @ about))
    if np.abs(command).min() > AWAY:
        return float(np.abs(np.median(values / command)))
    return _noise(values, noise) or 1.0


def _wrong(evidence: Evidence, name: str, scales: Mapping[int, float], column: int | None = None) -> Iterator[Found]:
    si = QUANTITIES[name].unit
    for index, scale in scales.items():
        unit = named_unit(si, scale)
        if unit is None:
            continue
        word, factor = unit
        signal = evidence.recordings[index][name]
        channel = "" if column is None else signal.channels[column]
        text = f"is {scale:.4g} times what it should be, as if in {word} instead of {si}"
        repair = Repair(name, channel, unit=word) if word in UNITS[si] else None
        count = len(signal.channels)
        factors = np.full(count, factor) if column is None else np.where(np.arange(count) == column, factor, 1.0)
        place = f"{name}/{channel}" if channel else name
        finding = evidence.finding("unit", index, place, text, Action.REPAIRED, True, repair=repair)
        yield Found(index, finding, mapped(name, factors, np.zeros(count)))


def named_unit(si: str, scale: float) -> tuple[str, float] | None:
    """The unit in which numbers are so many times what they are in SI, and its factor; None for a plausible scale."""
    if not np.isfinite(scale) or scale <= 0 or 1 / OFF < scale < OFF:
        return None
    known = {word: factor for word, factor in UNITS.get(si, {}).items() if factor != 1}
    for choices in (known, {f"{word} {si}": power for word, power in POWERS.items()}):
        near = {word: abs(np.log(scale * factor)) for word, factor in choices.items()}
        word = min(near, key=near.__getitem__, default="")
        if word and near[word] < np.log(NEAR):
            return word, choices[word]
    return None
