"""Where the gap lies: its power over sensor, link, direction, frequency band and phase of the experiment.

Bands come from the Fourier series of each channel, so that their powers add up; phases from the joints' motion and
the known load. Shares are of the whole squared residual, whitened, and sum to one.
"""

from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from boom_mj.diagnosis.linearisation import Linearisation
from boom_mj.systems.system import Band

Array = np.ndarray


@dataclass(frozen=True)
class Cell:
    """A part of the gap.

    Attributes:
        gap: root mean square of the whitened residual in it.
        share: of the whole squared residual.
    """

    sensor: str
    link: str
    direction: str
    band: str
    phase: str
    gap: float
    share: float


AXES = ("sensor", "link", "direction", "band", "phase")


def locate(model: Linearisation, residual: Array) -> tuple[Cell, ...]:
    """All cells of a whitened residual (N,), largest first."""
    power: dict[tuple[str, ...], float] = defaultdict(float)
    count: dict[tuple[str, ...], float] = defaultdict(float)
    data, system, facts = model.data, model.system, model.facts
    phases = [np.unique(system.timeline(log).phases(), return_inverse=True) for log in data.recordings]
    for number, channel in enumerate(data.channels):
        names, of_block = phases[channel.recording]
        when = of_block[np.minimum((channel.time / data.block_s).astype(int), len(of_block) - 1)]
        entries = np.bincount(when, minlength=len(names))
        at = system.channel(channel.signal, channel.column)
        place = at.sensor, at.part, at.direction
        for band, part in bands(residual[data.stretch(number)], facts.bands_hz, data.block_s):
            squares = np.bincount(when, part**2, len(names))
            for k in np.flatnonzero(entries):
                power[(*place, band, str(names[k]))] += float(squares[k])
                count[(*place, band, str(names[k]))] += float(entries[k])
    total = max(sum(power.values()), 1e-300)
    cells = [
        Cell(**dict(zip(AXES, key)), gap=float(np.sqrt(p / max(count[key], 1))), share=p / total)
        for key, p in power.items()
    ]
    return tuple(sorted(cells, key=lambda cell: -cell.share))


def shares(cells: Iterable[Cell], *axes: str) -> dict[tuple[str, ...], float]:
    """Shares summed over everything but the given axes, largest first."""
    found: dict[tuple[str, ...], float] = defaultdict(float)
    for cell in cells:
        found[tuple(getattr(cell, axis) for axis in axes)] += cell.share
    return dict(sorted(found.items(), key=lambda item: -item[1]))


def bands(series: Array, edges: Sequence[Band], step: float) -> list[tuple[str, Array]]:
    """The series' parts in each band, which add up to it."""
    spectrum, frequency = np.fft.rfft(series), np.fft.rfftfreq(len(series), step)
    parts, low = [], -1.0
    for name, high in edges:
        inside = (frequency > low) & (frequency <= high)
        parts.append((name, np.fft.irfft(np.where(inside, spectrum, 0), len(series))))
        low = high
    return parts


def in_words(cells: tuple[Cell, ...]) -> str:
    """One sentence: where most of it lies."""
    ways = {"sensor": "by {}", "link": "on {}", "direction": "along {}", "band": "in the {} band", "phase": "in {}"}
    parts = []
    for axis, words in ways.items():
        (name,), share = next(iter(shares(cells, axis).items()))
        parts += [words.format(f"{name} ({share:.0%})")] if name else []
    return f"it is seen most {', '.join(parts)}"


def looks_like(model: Linearisation, residual: Array) -> str:
    """What an unexplained residual looks like, by the regressor that takes most of it."""
    scores = {"periodic": 0.0, "odd in velocity": 0.0, "drifting": 0.0, "pose dependent": 0.0, "one-sided": 0.0}
    data, total = model.data, float(residual @ residual) + 1e-300
    lines = [model.system.timeline(log) for log in data.recordings]
    means: dict[tuple[str, int], list[float]] = defaultdict(list)
    for number, channel in enumerate(data.channels):
        series = residual[data.stretch(number)]
        if len(series) < 30:
            continue
        mean = float(series.mean())
        means[(channel.signal, channel.column)].append(mean * np.sqrt(len(series)))
        free = series - mean
        trend = channel.time - channel.time.mean()
        scores["drifting"] += float(free @ trend) ** 2 / float(trend @ trend) / total
        spectrum = np.abs(np.fft.rfft(free * np.hanning(len(free)))) ** 2
        peak = int(np.argmax(spectrum[1:])) + 1
        scores["periodic"] += (
            spectrum[max(1, peak - 1) : peak + 2].sum() / (spectrum.sum() + 1e-300) * (free @ free / total)
        )
        rate = np.gradient(lines[channel.recording].coordinates(channel.time), channel.time, axis=0)
        signs = np.sign(np.where(np.abs(rate) > 5 * model.facts.still, rate, 0.0))
        best = max((float(free @ s) ** 2 / float(s @ s) for s in signs.T if s @ s > 10), default=0.0)
        scores["odd in velocity"] += best / total
        skew = float(np.mean(free**3) / (np.mean(free**2) ** 1.5 + 1e-300))
        scores["one-sided"] += min(abs(skew) / 4, 1.0) * float(free @ free) / total * 0.5
    for values in means.values():
        scores["pose dependent"] += float(np.sum(np.square(values))) / total
    name = max(scores, key=lambda key: scores[key])
    if scores[name] < model.criteria.seen_share:
        return "nothing in particular"
    return f"{name} ({min(scores[name], 1.0):.0%} of it)"
