"""Single samples that are elsewhere."""

from collections.abc import Iterator, Mapping

import numpy as np
from scipy.ndimage import median_filter

from boom_mj.replay.quality.channels import own_noise, resolution
from boom_mj.replay.quality.check import Check, Found, Turn
from boom_mj.replay.quality.edits import blanked
from boom_mj.replay.quality.evidence import Evidence, sensor_of
from boom_mj.replay.quality.finding import Action

Array = np.ndarray
SIGMAS = 8.0  # of what the interpolation misses by noise: once in 1e15 samples
LIVELY = 12.0  # times what it misses around: fast motion is no outlier
AROUND = 51  # samples
ROUNDS = 12
TOGETHER, AFTER = 0.06, 0.3  # s within which two sensors see one blow, and how long it rings
FEWEST = 5  # left of them in a channel
SHARE = 0.01  # of an accelerometer's samples: blows of play that it sees alone make half as many
WHITE = np.sqrt(1 + 2 * (4 / 6) ** 2 + 2 * (1 / 6) ** 2)  # noise of sample less interpolation


class Spiky(Check):
    """Samples far from the cubic through their two neighbours on either side,

    r_i = x_i - (4 x_(i-1) + 4 x_(i+1) - x_(i-2) - x_(i+2)) / 6,

    beyond SIGMAS of its noise and LIVELY times its usual size around; the largest first, each replaced by the cubic, as
    its neighbours' r are wrong as well. What two sensors see at once is a blow, such as a rope's cut, and no outlier.
    """

    kind = "spiky"
    turn = Turn.SAMPLES

    def look(self, evidence: Evidence) -> Iterator[Found]:
        for index in evidence.indices:
            log, found = evidence.recordings[index], self._outliers(evidence, index)
            blows = _blows({name: log[name].time[bad.any(axis=1)] for name, bad in found.items()})
            for name, bad in found.items():
                signal = log[name]
                since = signal.time[:, None] - blows[None]
                bad = bad & ~((since > -TOGETHER) & (since < AFTER)).any(axis=1)[:, None]
                fewest = max(FEWEST, SHARE * len(bad)) if signal.unit == "m/s^2" else FEWEST
                for column in np.flatnonzero(bad.sum(axis=0) >= fewest):
                    where, values = np.flatnonzero(bad[:, column]), signal.values[:, column]
                    far = np.abs(values[where] - np.nanmedian(values)).max()
                    text = f"has {len(where)} outliers of {len(values)} samples, up to {far:.4g} {signal.unit} away"
                    only = bad & (np.arange(bad.shape[1]) == column)
                    channel = f"{name}/{signal.channels[column]}" if len(signal.channels) > 1 else name
                    span = float(signal.time[where[0]]), float(signal.time[where[-1]])
                    finding = evidence.finding(self.kind, index, channel, text, Action.CENSORED, True, span)
                    yield Found(index, finding, blanked(name, only))

    def _outliers(self, evidence: Evidence, index: int) -> dict[str, Array]:
        """By signal, (n, k) of bool."""
        found = {}
        for name in evidence.measured(index):
            signal, noise = evidence.recordings[index][name], evidence.noise(name)
            columns = zip(signal.values.T, noise)
            levels = [(values, max(level, own_noise(values), resolution(values))) for values, level in columns]
            bad = np.stack([outliers(values, level) for values, level in levels], axis=1)
            if bad.any():
                found[name] = bad
        return found


def _blows(times: Mapping[str, Array]) -> Array:
    """Moments at which several sensors have outliers, s."""
    sensors: dict[str, list[Array]] = {}
    for name, at in times.items():
        sensors.setdefault(sensor_of(name), []).append(at)
    merged = {sensor: np.concatenate(parts) for sensor, parts in sensors.items()}
    found = [np.zeros(0)]
    for sensor, at in merged.items():
        others = np.concatenate([np.zeros(0), *(t for other, t in merged.items() if other != sensor)])
        found.append(at[(np.abs(at[:, None] - others[None]) < TOGETHER).any(axis=1)])
    return np.concatenate(found)


def outliers(values: Array, noise: float) -> Array:
    """Where they are, (n,) of bool."""
    found, known = np.zeros(len(values), bool), np.flatnonzero(np.isfinite(values))
    x = values[known].copy()
    if len(x) < AROUND or noise <= 0:
        return found
    usual = LIVELY * median_filter(np.abs(x - _cubic(x)), AROUND, mode="nearest")
    limit = np.maximum(SIGMAS * WHITE * noise, usual)
    for _ in range(ROUNDS):
        inside = _cubic(x)
        excess = np.abs(x - inside) / limit
        excess[excess < 1] = 0.0
        padded = np.pad(excess, 2)
        peak = (excess > 0) & (excess >= np.max([padded[k : len(padded) - 4 + k] for k in range(5)], axis=0))
        if not peak.any():
            break
        x[peak] = inside[peak]
        found[known[peak]] = True
    return found


def _cubic(x: Array) -> Array:
    """What two neighbours on either side say; the ends as they are."""
    inside = x.copy()
    inside[2:-2] = (4 * x[1:-3] + 4 * x[3:-1] - x[:-4] - x[4:]) / 6
    return inside
