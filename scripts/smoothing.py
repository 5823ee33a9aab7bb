"""Which smoother of joint angles, by sensors that no smoother saw. Writes docs/explanation/smoothing.md.

Run: .venv/bin/python scripts/smoothing.py FOLDER   (about a minute; recordings of a healthy machine whose joints follow
their command exactly, and a file truth.json with the zero offsets of its angle sensors, joint_zero_offset_deg)
"""

import json
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
from scipy.interpolate import UnivariateSpline, make_interp_spline
from scipy.linalg import cholesky_banded, solveh_banded
from scipy.optimize import brentq, minimize_scalar
from scipy.signal import butter, sosfiltfilt

from boom_mj.logs import read_log
from boom_mj.machine import load_machine
from boom_mj.recording import Recording, named_signal
from boom_mj.replay import compare
from boom_mj.sensors import ideal_signals, noise_levels, sample
from boom_mj.simulation import Plant, make_plant, run, smooth_angles, step_times
from boom_mj.simulation.smoothing import resting, third_difference_bands

Array = np.ndarray
Smoother = Callable[[Array, Array, float, Array], Array]
ROOT = Path(__file__).parents[1]
LOGS = ("slew_t", "sweep", "mixed", "fold_in")
HINGES = 4
REST_WEIGHT = 1e6  # of a rest's mean against a single sample
LATERAL = ("specific_force/z", "angular_rate/y")  # what slewing shakes
BAND = 1.5  # Hz, below which accelerations are compared: they shake the boom


def spline(column: Array, step: float, noise: float) -> Array:
    """Smoothing spline of degree 5 that leaves the sensor's noise over."""
    time = step * np.arange(len(column))
    return UnivariateSpline(time, column, k=5, s=len(time) * noise**2)(time)


def butterworth(column: Array, step: float, noise: float) -> Array:
    """Butterworth of order 2 forwards and backwards, as low as leaves the sensor's noise over."""

    def filtered(log_hz: float) -> Array:
        ends = min(len(column) - 1, int(1.5 / step / 10**log_hz))
        return sosfiltfilt(butter(2, 10**log_hz, fs=1 / step, output="sos"), column, padlen=ends)

    return filtered(discrepancy(lambda x: column - filtered(x), noise, -1.3, np.log10(0.45 / step)))


def rts(column: Array, step: float, noise: float) -> Array:
    """Kalman filter and Rauch-Tung-Striebel smoother of a white jerk, of the likeliest size.

    Solved as the least squares problem that both passes solve.
    """

    def path(log_jerk: float) -> tuple[Array, float]:
        weight = np.full(len(column) - 3, 10 ** (-2 * log_jerk) / step**6)
        bands = third_difference_bands(weight)
        bands[-1] += 1 / noise**2
        found = solveh_banded(bands, column / noise**2)
        misfit = np.sum((column - found) ** 2) / noise**2 + weight @ np.diff(found, 3) ** 2
        return found, misfit + 2 * np.log(cholesky_banded(bands)[-1]).sum() - np.log(weight).sum()

    return path(minimize_scalar(lambda x: path(x)[1], bounds=(-4, 1), method="bounded", options={"xatol": 0.03}).x)[0]


def whittaker(column: Array, step: float, noise: float) -> Array:
    """Third differences penalised evenly, rests held at their mean, the noise left over where the joint moves."""
    still, weight, target = resting(column, step, noise), np.ones(len(column)), column.copy()
    edges = np.flatnonzero(np.diff(np.concatenate([[0], still.astype(int), [0]])))
    for start, stop in edges.reshape(-1, 2):
        target[start:stop], weight[start:stop] = column[start:stop].mean(), REST_WEIGHT
    if still.all():
        return target

    def path(log_softness: float) -> Array:
        bands = third_difference_bands(np.full(len(column) - 3, 10**-log_softness))
        bands[-1] += weight
        return solveh_banded(bands, weight * target)

    return path(discrepancy(lambda x: (column - path(x))[~still], noise, -9.0, 2.0))


def discrepancy(residual: Callable[[float], Array], noise: float, low: float, high: float) -> float:
    """Where between `low` (stiff) and `high` (soft) a smoother takes away as much as the sensor's noise."""

    def excess(x: float) -> float:
        return float(np.sqrt(np.mean(residual(x) ** 2)) - noise)

    if excess(low) < 0:
        return low
    return high if excess(high) > 0 else brentq(excess, low, high, xtol=0.02)


def of_columns(smooth: Callable[[Array, float, float], Array]) -> Smoother:
    """A smoother of evenly sampled columns as one of the package's kind."""

    def smoother(time: Array, angles: Array, noise: float, at: Array) -> Array:
        step = (time[-1] - time[0]) / (len(time) - 1)
        columns = [smooth(column, step, noise) for column in angles.T]
        return make_interp_spline(time, np.stack(columns, axis=1), k=5)(np.clip(at, time[0], time[-1]))

    return smoother


SMOOTHERS: dict[str, Smoother] = {
    "spline, local jerk (chosen)": smooth_angles,
    "Whittaker, rests held": of_columns(whittaker),
    "Kalman/RTS, white jerk": of_columns(rts),
    "smoothing spline": of_columns(spline),
    "Butterworth, zero phase": of_columns(butterworth),
}


def twin_ratios(plant: Plant, log: Recording, angles: Array) -> dict[str, float]:
    """rms(log - twin) over noise of every channel group, the joints going through `angles` at the steps."""
    time = step_times(plant, log["joint/position"].time[-1])
    ideal = ideal_signals(run(plant, angles, sample(log["load"], time)))
    seen = {
        name: named_signal(name, s.time, sample(ideal[name], s.time))
        for name, s in log.signals.items()
        if name in ideal
    }
    groups = compare(log, Recording(log.name, log.machine, "", seen), noise_levels(plant.machine))
    return {group.name: group.ratio for group in groups}


def row(name: str, ratios: dict[str, float], figures: list[str]) -> str:
    kinds = ("specific_force", "angular_rate", "markers", "cylinder")
    lateral = np.sqrt(np.mean([ratio**2 for group, ratio in ratios.items() if group.endswith(LATERAL)]))
    cells = [f"{np.median([r for g, r in ratios.items() if kind in g]):.2f}" for kind in kinds]
    return "| " + " | ".join([name, *figures, f"{lateral:.2f}", *cells]) + " |"


def table(plant: Plant, log: Recording, offsets: Array) -> list[str]:
    joints = log["joint/position"]
    read, noise = joints.values - offsets, float(noise_levels(plant.machine)["joint/position"][0])
    time = step_times(plant, joints.time[-1])
    command = make_interp_spline(joints.time, log["joint_command/position"].values, k=5)
    inside = np.clip(time, 0, joints.time[-1])
    true, acceleration = command(inside), command(inside, 2)
    sections = butter(2, BAND, fs=1 / (time[1] - time[0]), output="sos")
    rows = []
    for name, smooth in SMOOTHERS.items():
        angles = smooth(joints.time, read, noise, time)
        held_out = smooth(joints.time[::2], read[::2], noise, joints.time) - read
        twice = np.gradient(np.gradient(angles, time, axis=0), time, axis=0)
        shaking = np.degrees(sosfiltfilt(sections, twice - acceleration, axis=0))
        figures = [
            f"{np.sqrt(np.mean(held_out[1::2] ** 2)) / noise:.3f}",
            f"{1e3 * np.degrees(np.sqrt(np.mean((angles - true) ** 2))):.1f}",
            f"{np.sqrt(np.mean(shaking**2)):.3f}",
        ]
        rows.append(row(f"{log.name} | {name}", twin_ratios(plant, log, angles), figures))
        print(rows[-1], flush=True)
    rows.append(row(f"{log.name} | the true motion", twin_ratios(plant, log, true), ["", "0", "0"]))
    print(rows[-1], flush=True)
    return rows


def main() -> None:
    folder = Path(sys.argv[1])
    offsets = np.radians(json.loads((folder / "truth.json").read_text())["joint_zero_offset_deg"])
    plant, rows = make_plant(load_machine(ROOT / "models" / "boom36.toml"), HINGES), []
    for name in LOGS:
        rows += table(plant, read_log(next(folder.rglob(f"{name}.mcap"))), offsets)
    text = (ROOT / "docs" / "explanation" / "smoothing.md.in").read_text()
    (ROOT / "docs" / "explanation" / "smoothing.md").write_text(text.replace("{rows}", "\n".join(rows)))
    print(f"wrote {ROOT / 'docs' / 'explanation' / 'smoothing.md'}")


if __name__ == "__main__":
    main()
