"""A calibrated machine against measurements, as the paper shows it: stationary differences and first frequencies.

Simulated recordings pass through the same evaluation as measured ones: the fall of marker 12 along the load that went,
and the strongest mode of what follows. "Uncalibrated" is the machine file as it was with the zero offsets that were
found.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from boom_mj.calibration.calibrate import Calibration
from boom_mj.calibration.decay import fit_decay
from boom_mj.calibration.evidence import FINE, predictor_of
from boom_mj.calibration.parameters import Variant
from boom_mj.calibration.release import LEAST_DECAY, SETTLED, release_of, stop_of
from boom_mj.estimation.channels import Table
from boom_mj.recording import Recording, named_signal
from boom_mj.replay import Group, compare
from boom_mj.sensors import ideal_signals, noise_levels, sample
from boom_mj.simulation import Plant, Trajectory, make_plant
from boom_mj.systems.boom import BoomSystem
from boom_mj.systems.predictor import Predictor

Array = np.ndarray
SEEN = 0.5  # share of the scatter after a stop that modes must take to count as a vibration
MACHINES = ("uncalibrated", "calibrated")


@dataclass(frozen=True, eq=False)
class Twin:
    """A simulated recording.

    Attributes:
        motion: the simulation.
        table: its means over the samples that the recording has.
        groups: how far log and simulation are apart, by channel group, in units of sensor noise.
    """

    motion: Trajectory
    table: Table
    groups: tuple[Group, ...]


@dataclass(frozen=True)
class Comparison:
    """One experiment: measured, uncalibrated, calibrated, each figure (3,).

    Attributes:
        name: of the experiment.
        direction: "vertical" or "horizontal" for a load that is cut, "slewing" for a motion that stops.
        index: of the recording.
        fall: stationary difference of marker 12 along the load, m; NaN without a load.
        frequency: of the strongest mode, Hz.
        damping_ratio: of that mode.
    """

    name: str
    direction: str
    index: int
    fall: Array
    frequency: Array
    damping_ratio: Array


@dataclass(frozen=True, eq=False)
class Validation:
    """A calibration, its recordings and others that it has not seen, and simulations of all.

    Attributes:
        logs: all recordings, as block means.
        training: how many of them the calibration has seen.
        twins: per recording the simulation of the uncalibrated and of the calibrated machine.
        comparisons: of the recordings that end a load or a motion.
    """

    found: Calibration
    logs: tuple[Table, ...]
    training: int
    twins: tuple[tuple[Twin, Twin], ...]
    comparisons: tuple[Comparison, ...]


def validate(found: Calibration, held_out: Sequence[Recording] = ()) -> Validation:
    """Compare both machines with all recordings."""
    seen = found.predictor.data.recordings
    predictor = predictor_of(found.machine, [*seen, *held_out])
    tables = tuple(predictor.data.table(index) for index in range(len(predictor.data.recordings)))
    twins = tuple(
        (_twin(predictor, found.nominal, table, index), _twin(predictor, found.variant, table, index))
        for index, table in enumerate(tables)
    )
    plant = make_plant(found.variant.machine, FINE.hinges)
    rows = (
        _release(plant, index, both, pair) or _stop(plant, index, both, pair)
        for index, (both, pair) in enumerate(zip(tables, twins))
    )
    return Validation(found, tables, len(seen), twins, tuple(row for row in rows if row is not None))


def validation_document(shown: Validation) -> dict[str, Any]:
    """The comparison in plain data."""
    held_out = range(shown.training, len(shown.logs))
    return {
        "experiments": [
            {
                "name": row.name,
                "direction": row.direction,
                "held_out": row.index >= shown.training,
                **{
                    what: {**dict(zip(("measured", *MACHINES), map(_plain, values))), "error": errors(values)}
                    for what, values in (("fall_m", row.fall), ("frequency_hz", row.frequency))
                    if np.isfinite(values[0])
                },
                "damping_ratio": dict(zip(("measured", *MACHINES), map(_plain, row.damping_ratio))),
            }
            for row in shown.comparisons
        ],
        "held_out": {
            shown.logs[k].log.name: {
                machine: {group.name: group.ratio for group in twin.groups}
                for machine, twin in zip(MACHINES, shown.twins[k])
            }
            for k in held_out
        },
    }


def errors(values: Array) -> dict[str, float | None]:
    """Relative errors of both machines."""
    return {machine: _plain(value / values[0] - 1) for machine, value in zip(MACHINES, values[1:])}


def _plain(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None


def _twin(predictor: Predictor, variant: Variant, table: Table, index: int) -> Twin:
    data, log = predictor.data, table.log
    motion = BoomSystem(variant.machine).run(variant.sensor, FINE, log)
    signals = ideal_signals(motion)
    at = {name: log[name].time - table.start_s for name in log.signals if name in signals}
    sampled = {name: named_signal(name, log[name].time, sample(signals[name], time)) for name, time in at.items()}
    recording = Recording(log.name, log.machine, "simulated twin", sampled)
    names = dict.fromkeys(channel.signal for channel in table.channels)
    means = table.saying(np.concatenate([data.means(index, name, signals[name]) for name in names]))
    return Twin(motion, means, compare(log, recording, noise_levels(variant.machine)))


def _release(plant: Plant, index: int, table: Table, twins: tuple[Twin, Twin]) -> Comparison | None:
    found = [release_of(b, index, plant) for b in (table, *(twin.table for twin in twins))]
    releases = [release for release in found if release is not None]
    if len(releases) < len(found):
        return None
    load = releases[0].before.load
    along = load / np.linalg.norm(load)
    frequency, ratio = np.array([release.first for release in releases]).T
    return Comparison(
        name=releases[0].name,
        direction="vertical" if abs(along[2]) > abs(along[1]) else "horizontal",
        index=index,
        fall=np.array([-release.fall[-3:] @ along for release in releases]),
        frequency=frequency,
        damping_ratio=ratio,
    )


def _stop(plant: Plant, index: int, table: Table, twins: tuple[Twin, Twin]) -> Comparison | None:
    """The vibration after a motion that stops: the modes that joint 1 excites."""
    stop = stop_of(table)
    if stop is None or table.time[-1] - stop < 2 * LEAST_DECAY:
        return None
    rest = plant.static_equilibrium(table.log["joint/position"].values[-50:].mean(axis=0))
    modes = plant.modes(rest)
    pushed = plant.mass_matrix(rest)[np.ix_(plant.elastic, plant.joints[:1])][:, 0]
    strongest = np.argsort(-np.abs(modes.shape.T @ pushed))[:2]
    expected, ratio = modes.frequency[strongest], float(modes.damping_ratio[strongest[0]])
    rows = table.time > stop + SETTLED
    fits = [
        fit_decay(b.time[rows] - stop, b.mean[rows], b.noise[rows], expected, ratio)
        for b in (table, *(twin.table for twin in twins))
    ]
    first = [int(np.argmin(np.abs(np.log(fit.frequency / expected[0])))) for fit in fits]
    if fits[0].share < SEEN:
        return None
    return Comparison(
        name=table.log.name,
        direction="slewing",
        index=index,
        fall=np.full(len(fits), np.nan),
        frequency=np.array([fit.frequency[k] for fit, k in zip(fits, first)]),
        damping_ratio=np.array([fit.damping_ratio[k] for fit, k in zip(fits, first)]),
    )
