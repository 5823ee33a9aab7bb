"""Is a log worth replaying? Excitation, rates against the first modes, noise against the machine file, holes.

The noise of a channel is the scatter of its second differences, by their median, in the quieter half of the log: a mode
of frequency f leaves (2 pi f / rate)^2 of its amplitude there. Excitation is what neighbouring samples share: noise is
white and has no part in the product of one sample with the next.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from boom_mj.errors import LogError
from boom_mj.recording import Recording, Signal
from boom_mj.sensors.measure import noise_levels
from boom_mj.simulation import Plant
from boom_mj.simulation.smoothing import white_noise

Array = np.ndarray
FIRST_MODES = 4  # two upwards, two sideways
SAMPLES_PER_PERIOD = 8.0
MOVES = 0.5  # of the noise, from which on a channel counts as excited
NOISE_RANGE = (0.5, 1.5)  # of the machine file's, within which a channel is as noisy as it says
WINDOW = 2.0  # s, of which the quieter half is looked for
MISSING, HOLE = 0.01, 5.0  # share of samples, usual steps: beyond these a signal has holes


@dataclass(frozen=True)
class ChannelQuality:
    """One channel.

    Attributes:
        noise: standard deviation of what is white in it, in the signal's unit.
        expected_noise: by the machine file.
        excitation: standard deviation of what is not white, over the larger of both noises.
    """

    name: str
    noise: float
    expected_noise: float
    excitation: float

    @property
    def noise_ratio(self) -> float:
        return self.noise / self.expected_noise if self.expected_noise else float("inf")

    @property
    def moves(self) -> bool:
        return self.excitation > MOVES


@dataclass(frozen=True)
class SignalQuality:
    """One signal.

    Attributes:
        rate_hz: of the usual step.
        samples_per_period: of the fastest of the first modes.
        missing: share of NaN.
        longest_gap: longest step, s.
        longest_gap_at: when it begins, s.
    """

    name: str
    rate_hz: float
    samples_per_period: float
    missing: float
    longest_gap: float
    longest_gap_at: float
    channels: tuple[ChannelQuality, ...]

    def remarks(self) -> Iterator[str]:
        """What is wrong with it, one sentence each."""
        if self.samples_per_period < SAMPLES_PER_PERIOD:
            yield (
                f"{self.name} at {self.rate_hz:.1f} Hz has {self.samples_per_period:.1f} samples in a period of the "
                f"boom's first {FIRST_MODES} modes; {SAMPLES_PER_PERIOD:g} are needed, "
                f"{self.rate_hz * SAMPLES_PER_PERIOD / self.samples_per_period:.0f} Hz"
            )
        if self.missing > MISSING:
            yield f"{100 * self.missing:.0f} % of {self.name} are missing"
        if self.longest_gap * self.rate_hz > HOLE:
            yield f"{self.name} has a gap of {self.longest_gap:.2f} s at {self.longest_gap_at:.2f} s"
        low, high = NOISE_RANGE
        for word, wrong in (
            ("more", [c for c in self.channels if c.noise_ratio > high]),
            ("less", [c for c in self.channels if c.noise_ratio < low]),
        ):
            if wrong:
                ratios = sorted(c.noise_ratio for c in wrong)
                span = f"{ratios[0]:.2g}" if len(wrong) == 1 else f"{ratios[0]:.2g} to {ratios[-1]:.2g}"
                yield (
                    f"{self.name} {_listed([c.name for c in wrong])} scatters {word} than the machine file says: "
                    f"{span} x its noise"
                )


@dataclass(frozen=True)
class Quality:
    """Of all the signals whose noise the machine file knows.

    Attributes:
        modes_hz: the boom's first natural frequencies in the log's first pose.
    """

    modes_hz: tuple[float, ...]
    signals: tuple[SignalQuality, ...]

    def summary(self) -> str:
        """The log in a sentence."""
        joints = next(signal for signal in self.signals if signal.name == "joint/position")
        moving = [channel.name for channel in joints.channels if channel.moves]
        others = [channel for signal in self.signals if signal is not joints for channel in signal.channels]
        return (
            f"moving: {_listed(moving) or 'no joint'}, {sum(c.moves for c in others)} of {len(others)} other channels; "
            f"modes {', '.join(f'{f:.2f}' for f in self.modes_hz)} Hz, "
            f"{min(s.samples_per_period for s in self.signals):.1f} samples or more in the shortest period"
        )

    def remarks(self) -> tuple[str, ...]:
        """What is wrong, one sentence each; empty for a good log."""
        found = [remark for signal in self.signals for remark in signal.remarks()]
        if not any(channel.moves for signal in self.signals for channel in signal.channels):
            found.insert(
                0, "no channel moves above its noise: the log shows the boom at rest and nothing of its motion"
            )
        return tuple(found)


def assess(plant: Plant, log: Recording) -> Quality:
    """Judge a log before it drives a model.

    Raises:
        LogError: the joint angles are missing, or never all known at once.
    """
    joints = log["joint/position"]
    known = np.isfinite(joints.values).all(axis=1)
    if not known.any():
        raise LogError(f"log {log.name!r}: there is no time at which all joint angles are numbers")
    rest = plant.static_equilibrium(joints.values[np.argmax(known)])
    modes = plant.modes(rest).frequency[:FIRST_MODES]
    levels = noise_levels(plant.machine)
    signals = (_signal_quality(name, log[name], level, modes[-1]) for name, level in levels.items() if name in log)
    return Quality(tuple(map(float, modes)), tuple(signals))


def _signal_quality(name: str, signal: Signal, expected: Array, fastest: float) -> SignalQuality:
    steps = np.diff(signal.time)
    rate = float(1 / np.median(steps)) if steps.size else 0.0
    longest = int(np.argmax(steps)) if steps.size else 0
    return SignalQuality(
        name=name,
        rate_hz=rate,
        samples_per_period=rate / fastest,
        missing=float(np.isnan(signal.values).mean()),
        longest_gap=float(steps[longest]) if steps.size else 0.0,
        longest_gap_at=float(signal.time[longest]),
        channels=tuple(
            _channel_quality(channel, values, float(level), max(3, round(WINDOW * rate)))
            for channel, values, level in zip(signal.channels, signal.values.T, expected)
        ),
    )


def _channel_quality(name: str, values: Array, expected: float, window: int) -> ChannelQuality:
    values = values[np.isfinite(values)]
    if len(values) < 3:
        return ChannelQuality(name, float("nan"), expected, 0.0)
    noise = _quiet(values, window)
    about = values - values.mean()
    shared = np.sqrt(max(float(np.mean(about[1:] * about[:-1])), 0.0))
    return ChannelQuality(name, noise, expected, float(shared / max(noise, expected, 1e-300)))


def quiet_noise(time: Array, values: Array) -> float:
    """Standard deviation of what is white in the quieter half of a channel."""
    return _quiet(values[np.isfinite(values)], max(3, round(WINDOW / float(np.median(np.diff(time))))))


def _quiet(values: Array, window: int) -> float:
    """The same, of samples without NaN in windows of so many."""
    pieces = values[: max(1, len(values) // window) * window]
    pieces = pieces.reshape(-1, min(window, len(pieces)))  # (windows, samples)
    spread = pieces.std(axis=1)
    quiet = pieces[spread <= np.median(spread)]
    return float(np.sqrt(np.mean(white_noise(quiet.T) ** 2)))


def _listed(names: list[str]) -> str:
    """Names in a row, cut where they are many."""
    return ", ".join(names) if len(names) <= 5 else f"{', '.join(names[:4])} and {len(names) - 4} more"
