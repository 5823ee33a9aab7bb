"""What rope-cut recordings say without simulating time: loads at rest, the fall of the markers, modes.

Sensors of joints are off by a degree, so that the paper compares relative displacements: the markers with the load and
without. Where the boom comes to rest after the cut is the constant of its decay.
"""

from dataclasses import dataclass

import numpy as np

from boom_mj.calibration.decay import Decay, fit_decay
from boom_mj.estimation.channels import Table
from boom_mj.simulation import Plant
from boom_mj.simulation.plant import Vibration
from boom_mj.systems.boom.system import BLOCK_S

Array = np.ndarray
MODES = 2  # of a release that are followed
SETTLED = 0.5  # s after the cut, when the fast modes are gone
LEAST_REST, LEAST_DECAY = 1.0, 5.0  # s
STILL = 2e-3  # rad, by which joints may wander in an experiment without motion
DROP = 50.0  # N


@dataclass(frozen=True)
class Rest:
    """A pose, a load, and the cylinder forces that were measured there at rest.

    Attributes:
        joints: reading, (5,), rad.
        load: force on the tip, (3,), N.
        cylinders: (2,), N; NaN where there were none.
        deviation: (2,), N.
    """

    joints: Array
    load: Array
    cylinders: Array
    deviation: Array


@dataclass(frozen=True)
class Release:
    """A load at rest, its end, and the vibration that follows.

    Attributes:
        name: of the recording.
        index: of the recording.
        cut: when the load falls, s from the first joint angle.
        before, after: rest with and without the load.
        place: markers without the load, (36,), m; NaN where hidden, and so the fall.
        fall: markers without the load less markers with it, (36,), m.
        place_deviation, fall_deviation: (36,), m.
        decay: modes of the vibration.
    """

    name: str
    index: int
    cut: float
    before: Rest
    after: Rest
    place: Array
    fall: Array
    place_deviation: Array
    fall_deviation: Array
    decay: Decay

    @property
    def first(self) -> tuple[float, float]:
        """Frequency (Hz) and damping ratio of the slowest of its modes, which is the strongest in a free boom."""
        return float(self.decay.frequency[0]), float(self.decay.damping_ratio[0])


def first_rest(table: Table) -> Rest | None:
    """The rest at the begin of a recording, where there is one."""
    end = min(_cut(table) or np.inf, _motion(table))
    rows = table.time < end - BLOCK_S
    if np.count_nonzero(rows) * BLOCK_S < LEAST_REST:
        return None
    inside = table.log["joint/position"].time - table.start_s < end - BLOCK_S
    joints = np.nanmean(table.log["joint/position"].values[inside], axis=0)
    load = table.log["load"].values[0] if "load" in table.log else np.zeros(3)
    return Rest(joints, load, *_cylinders(table, *_mean(table, rows)))


def release_of(table: Table, index: int, plant: Plant) -> Release | None:
    """What a recording says if its load is cut with the joints at rest; else None.

    Args:
        plant: that says near which frequencies to look.
    """
    cut = _cut(table)
    if cut is None or np.isfinite(_motion(table)):
        return None
    before, rows = first_rest(table), table.time > cut + SETTLED
    if before is None or np.count_nonzero(rows) * BLOCK_S < LEAST_DECAY or "markers" not in table.log:
        return None
    free, bent = (plant.static_equilibrium(before.joints, load) for load in (np.zeros(3), before.load))
    strongest, modes = excited_modes(plant, free, bent)
    expected, ratio = modes.frequency[strongest], float(modes.damping_ratio[strongest[0]])
    decay = fit_decay(table.time[rows] - cut, table.mean[rows], table.noise[rows], expected, ratio)
    loaded, error = _mean(table, table.time < cut - BLOCK_S)
    markers = [k for k, column in enumerate(table.channels) if column.signal == "markers"]
    after = Rest(before.joints, np.zeros(3), *_cylinders(table, decay.constant, decay.constant_deviation))
    return Release(
        name=table.log.name,
        index=index,
        cut=cut,
        before=before,
        after=after,
        place=decay.constant[markers],
        fall=(decay.constant - loaded)[markers],
        place_deviation=decay.constant_deviation[markers],
        fall_deviation=np.hypot(error, decay.constant_deviation)[markers],
        decay=decay,
    )


def excited_modes(plant: Plant, rest: Array, bent: Array) -> tuple[Array, Vibration]:
    """Numbers of the MODES modes that the end of a load excites most, strongest first, and all modes.

    Args:
        rest, bent: qpos without and with the load, (nq,).
    """
    modes = plant.modes(rest)
    mass = plant.mass_matrix(rest)[np.ix_(plant.elastic, plant.elastic)]
    strength = np.abs(modes.shape.T @ mass @ (bent - rest)[plant.elastic]) * modes.frequency
    return np.argsort(-strength)[:MODES], modes


def _mean(table: Table, rows: Array) -> tuple[Array, Array]:
    """Means of all channels over some blocks, and their standard deviations, (k,) each."""
    weight = np.where(np.isfinite(table.mean[rows]), 1 / table.noise[rows] ** 2, 0.0)
    total = weight.sum(axis=0)
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.nansum(weight * np.nan_to_num(table.mean[rows]), axis=0) / total, 1 / np.sqrt(total)


def _cylinders(table: Table, mean: Array, deviation: Array) -> tuple[Array, Array]:
    columns = [k for k, column in enumerate(table.channels) if column.signal == "cylinder/force"]
    if not columns:
        return np.full(2, np.nan), np.full(2, np.nan)
    return mean[columns], deviation[columns]


def _cut(table: Table) -> float | None:
    """When the load ends, s; None where it never does."""
    if "load" not in table.log:
        return None
    load = table.log["load"]
    size = np.linalg.norm(load.values, axis=1)
    fallen = np.flatnonzero(size < size[0] - DROP)
    return float(load.time[fallen[0]] - table.start_s) if fallen.size else None


def _motion(table: Table) -> float:
    """When the first joint moves, s; infinite where none does."""
    away = _away(table, 0)
    return float(away[0]) if away.size else np.inf


def begin_of_vibration(table: Table) -> float | None:
    """When a load ends or the last joint stops, s; None where neither happens."""
    cut, stop = _cut(table), stop_of(table)
    return cut if stop is None else stop


def stop_of(table: Table) -> float | None:
    """When the last joint comes to rest, s; None where none moves."""
    away = _away(table, -1)
    return float(away[-1]) if away.size else None


def _away(table: Table, end: int) -> Array:
    """Times at which a joint is not where it is at the begin (0) or the end (-1) of the recording, (m,), s."""
    joints = table.log["joint/position"]
    path = table.log.signals.get("joint_command/position", joints)
    few = max(1, len(path.time) // 50)
    there = np.nanmean(path.values[:few] if end == 0 else path.values[-few:], axis=0)
    limit = STILL + 4 * np.nanstd(np.diff(path.values, axis=0), axis=0) / np.sqrt(2)
    return path.time[(np.abs(path.values - there) > limit).any(axis=1)] - table.start_s
