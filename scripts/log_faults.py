"""What logs are spoiled with: faults of random channel, place and size, each with the kinds of finding that name it."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from boom_mj.machine import load_machine
from boom_mj.recording import Recording, Signal
from boom_mj.sensors import noise_levels

Array = np.ndarray
Rng = np.random.Generator
Logs = list[Recording]
IMUS = tuple(f"imu/link{k}" for k in (2, 3, 4, 5))
DRIVE, COMMAND, MARKERS, FORCE = "joint/position", "joint_command/position", "markers", "cylinder/force"


@dataclass(frozen=True)
class Fault:
    """What was done to a set: kinds of finding that name it, where, and in which logs."""

    name: str
    kinds: tuple[str, ...]
    channels: tuple[str, ...]
    logs: tuple[int, ...]


@dataclass(frozen=True)
class Set:
    """Recordings of a case, training first."""

    logs: Logs
    training: int


def at(channel: str, fault: Fault) -> bool:
    """Whether a finding's channel is a fault's, or part of it, or the sensor that it is part of."""
    return any(
        channel == c or (c and (channel.startswith(f"{c}/") or c.startswith(f"{channel}/"))) for c in fault.channels
    )


def some(rng: Rng, spoiled: Set) -> list[int]:
    """All logs of a set, or a few."""
    count = len(spoiled.logs)
    return list(range(count)) if rng.random() < 0.5 else sorted(rng.choice(count, rng.integers(1, 4), replace=False))


def change(log: Recording, name: str, values: Callable[[Array, Array], Array]) -> Recording:
    signal = log[name]
    return log.with_signals({name: replace(signal, values=values(signal.values.copy(), signal.time - signal.time[0]))})


def without(log: Recording, prefix: str) -> Recording:
    return replace(log, signals={k: s for k, s in log.signals.items() if not k.startswith(prefix)})


def picked(signal: Signal, keep: Array) -> Signal:
    return replace(signal, time=signal.time[keep], values=signal.values[keep])


def noisy_column(rng: Rng, log: Recording) -> tuple[str, int, str]:
    """A channel of any sensor but the joints: signal, column, name."""
    names = [n for n in noise_levels(MACHINE) if n in log and n != DRIVE]
    name = str(rng.choice(names))
    column = int(rng.integers(len(log[name].channels)))
    return name, column, f"{name}/{log[name].channels[column]}"


def dead(rng: Rng, spoiled: Set) -> Fault:
    """An IMU, the cylinders or all markers say one value, from the start or from a moment on."""
    sensor, at = str(rng.choice([*IMUS, FORCE, MARKERS])), some(rng, spoiled)
    since, zero = rng.choice([0.0, rng.uniform(0.1, 0.8)]), rng.random() < 0.5
    for k in at:
        for name in [n for n in spoiled.logs[k].signals if n.startswith(sensor)]:

            def stuck(v: Array, t: Array) -> Array:
                late = t >= since * t[-1]
                v[late] = 0.0 if zero else v[np.argmax(late)]
                return v

            spoiled.logs[k] = change(spoiled.logs[k], name, stuck)
    return Fault("sensor dead or stuck", ("constant",), (sensor,), tuple(at))


def swapped(rng: Rng, spoiled: Set) -> Fault:
    """Plugs of two IMUs, two markers or both cylinders."""
    what = rng.integers(3)
    at = list(range(len(spoiled.logs)))
    if what == 0:
        a, b = rng.choice(IMUS, 2, replace=False)
        for k in at:
            log = spoiled.logs[k]
            pairs = [(f"{x}/{q}", f"{y}/{q}") for x, y in ((a, b), (b, a)) for q in ("specific_force", "angular_rate")]
            spoiled.logs[k] = log.with_signals({to: replace(log[of], frame=log[to].frame) for to, of in pairs})
        return Fault("two IMUs swapped", ("swapped",), (str(a), str(b)), tuple(at))
    if what == 1:
        i, j = (int(x) for x in rng.choice(12, 2, replace=False))
        order = list(range(36))
        order[3 * i : 3 * i + 3], order[3 * j : 3 * j + 3] = range(3 * j, 3 * j + 3), range(3 * i, 3 * i + 3)
        for k in at:
            spoiled.logs[k] = change(spoiled.logs[k], MARKERS, lambda v, t: v[:, order])
        return Fault(
            "two markers swapped", ("swapped",), (f"markers/marker{i + 1}", f"markers/marker{j + 1}"), tuple(at)
        )
    for k in at:
        spoiled.logs[k] = change(spoiled.logs[k], FORCE, lambda v, t: v[:, ::-1])
    return Fault("cylinders swapped", ("swapped",), (FORCE,), tuple(at))


def sign(rng: Rng, spoiled: Set) -> Fault:
    """One axis of an IMU, one coordinate of a marker, one cylinder or one joint."""
    names = [f"{imu}/{q}" for imu in IMUS for q in ("specific_force", "angular_rate")]
    name = str(rng.choice([*names, MARKERS, FORCE, DRIVE]))
    signal = spoiled.logs[0][name]
    column, at = int(rng.integers(len(signal.channels))), tuple(range(len(spoiled.logs)))
    for k in at:
        spoiled.logs[k] = change(
            spoiled.logs[k], name, lambda v, t: v * np.where(np.arange(v.shape[1]) == column, -1, 1)
        )
    return Fault(f"sign turned: {name.rpartition('/')[2]}", ("sign",), (f"{name}/{signal.channels[column]}",), at)


def unit(rng: Rng, spoiled: Set) -> Fault:
    """Force in kN, markers in mm or cm, an IMU in g or deg/s."""
    imu = str(rng.choice(IMUS))
    name, factor = (
        (FORCE, 1e-3), (MARKERS, 1e3), (MARKERS, 1e2), (f"{imu}/specific_force", 1 / 9.80665),
        (f"{imu}/angular_rate", 180 / np.pi),
    )[rng.integers(5)]  # fmt: skip
    at = some(rng, spoiled)
    for k in at:
        spoiled.logs[k] = change(spoiled.logs[k], name, lambda v, t: v * factor)
    return Fault(f"unit: {name.rpartition('/')[2]}", ("unit",), (name,), tuple(at))


def joint_unit(rng: Rng, spoiled: Set) -> Fault:
    """Joint 1, whose angles are small, in degrees."""
    at = tuple(range(len(spoiled.logs)))
    for k in at:
        spoiled.logs[k] = change(spoiled.logs[k], DRIVE, lambda v, t: v * [180 / np.pi, 1, 1, 1, 1])
    return Fault("joint 1 in degrees", ("unit",), (f"{DRIVE}/joint1",), at)


def load(rng: Rng, spoiled: Set) -> Fault:
    """The known load in kN, or not logged."""
    gone = rng.random() < 0.5
    at = [k for k, log in enumerate(spoiled.logs) if np.abs(log["load"].values).max() > 100]
    for k in at:
        log = spoiled.logs[k]
        spoiled.logs[k] = without(log, "load") if gone else change(log, "load", lambda v, t: v / 1000)
    return Fault("load missing" if gone else "load in kN", ("load",), ("load",), tuple(at))


def frozen(rng: Rng, spoiled: Set) -> Fault:
    """A joint angle that stands for 2 to 6 s while its command moves."""
    moving = [
        (k, j, i)
        for k, log in enumerate(spoiled.logs)
        for j in range(5)
        for i in np.flatnonzero(np.abs(np.gradient(log[COMMAND].values[:, j], log[COMMAND].time)) > 0.01)[::50]
    ]
    k, j, i = moving[rng.integers(len(moving))]
    start, lasts = spoiled.logs[k][DRIVE].time[i] - 1.0, rng.uniform(2, 6)

    def still(v: Array, t: Array) -> Array:
        inside = (t >= start) & (t <= start + lasts)
        v[inside, j] = v[np.argmax(inside), j]
        return v

    spoiled.logs[k] = change(spoiled.logs[k], DRIVE, still)
    return Fault("joint frozen", ("constant", "frozen"), (f"{DRIVE}/joint{j + 1}",), (k,))


def quantised(rng: Rng, spoiled: Set) -> Fault:
    """A joint in steps of 0.05 to 0.2 deg, or a sensor in steps of 3 to 10 times its noise."""
    if rng.random() < 0.5:
        name, column = DRIVE, int(rng.integers(5))
        step, channel = np.radians(rng.uniform(0.05, 0.2)), f"{DRIVE}/joint{column + 1}"
    else:
        name, column, channel = noisy_column(rng, spoiled.logs[0])
        step = rng.uniform(3, 10) * noise_levels(MACHINE)[name][column]
    at = some(rng, spoiled)
    for k in at:

        def coarse(v: Array, t: Array) -> Array:
            v[:, column] = step * np.round(v[:, column] / step)
            return v

        spoiled.logs[k] = change(spoiled.logs[k], name, coarse)
    return Fault("quantised", ("quantised", "constant"), (channel,), tuple(at))


def outliers(rng: Rng, spoiled: Set) -> Fault:
    """0.5 to 3 % of a sensor's samples, 20 to 200 times its noise away."""
    name = str(rng.choice([MARKERS, FORCE, *(f"{imu}/specific_force" for imu in IMUS)]))
    share, size = rng.uniform(0.015, 0.03), rng.uniform(30, 200) * noise_levels(MACHINE)[name]
    at = some(rng, spoiled)
    for k in at:
        spoiled.logs[k] = change(
            spoiled.logs[k], name,
            lambda v, t: v + (rng.random(v.shape) < share) * rng.choice([-1, 1], v.shape) * size,
        )  # fmt: skip
    return Fault("outliers", ("spiky",), (name,), tuple(at))


def saturated(rng: Rng, spoiled: Set) -> Fault:
    """An accelerometer or a cylinder force that stops short of its largest values."""
    name = f"{rng.choice(IMUS)}/specific_force"
    at, column = some(rng, spoiled), int(rng.integers(2))
    whole = np.concatenate([np.abs(spoiled.logs[k][name].values[:, column]) for k in at])
    limit = float(np.quantile(whole, rng.uniform(0.6, 0.98)))
    hit = tuple(k for k in at if (np.abs(spoiled.logs[k][name].values[:, column]) > limit).mean() > 0.01)
    for k in at:

        def cut(v: Array, t: Array) -> Array:
            v[:, column] = np.clip(v[:, column], -limit, limit)
            return v

        spoiled.logs[k] = change(spoiled.logs[k], name, cut)
    return Fault("saturated", ("saturated", "constant"), (f"{name}/{'xyz'[column]}",), hit or tuple(at))


def lost(rng: Rng, spoiled: Set) -> Fault:
    """5 % of a sensor's messages and a hole of 0.8 to 2 s."""
    sensor, at = str(rng.choice([*IMUS, FORCE, MARKERS])), some(rng, spoiled)
    for k in at:
        log = spoiled.logs[k]
        names = [n for n in log.signals if n.startswith(sensor)]
        t = log[names[0]].time
        begin = rng.uniform(t[0] + 1, t[-1] - 4)
        keep = (rng.random(len(t)) > 0.05) & ~((t > begin) & (t < begin + rng.uniform(0.8, 2)))
        spoiled.logs[k] = log.with_signals({n: picked(log[n], keep) for n in names})
    return Fault("messages lost", ("dropped",), (sensor,), tuple(at))


def jump(rng: Rng, spoiled: Set) -> Fault:
    """Stamps of a sensor leap by 0.1 to 2 s."""
    sensor, at = str(rng.choice([*IMUS, FORCE, MARKERS])), some(rng, spoiled)
    for k in at:
        log, leap, when = spoiled.logs[k], rng.uniform(0.15, 2), rng.uniform(0.1, 0.9)
        names = [n for n in log.signals if n.startswith(sensor)]
        t = log[names[0]].time
        later = np.where(t > t[0] + when * (t[-1] - t[0]), t + leap, t)
        spoiled.logs[k] = log.with_signals({n: replace(log[n], time=later) for n in names})
    return Fault("clock jumps", ("clock",), (sensor,), tuple(at))


def drift(rng: Rng, spoiled: Set) -> Fault:
    """A sensor's clock is 1 to 5 per mille too fast or too slow."""
    sensor, pace = str(rng.choice([*IMUS, FORCE, MARKERS])), rng.uniform(1e-3, 5e-3) * rng.choice([-1, 1])
    at = tuple(range(len(spoiled.logs)))
    for k in at:
        log = spoiled.logs[k]
        names = [n for n in log.signals if n.startswith(sensor)]
        spoiled.logs[k] = log.with_signals({n: replace(log[n], time=log[n].time * (1 + pace)) for n in names})
    return Fault("clock drifts", ("clock",), (sensor,), at)


def joints_late(rng: Rng, spoiled: Set) -> Fault:
    """Joint angles 0.15 to 0.5 s late, their commands not."""
    late, at = rng.uniform(0.15, 0.5), tuple(range(len(spoiled.logs)))
    for k in at:
        joints = spoiled.logs[k][DRIVE]
        spoiled.logs[k] = spoiled.logs[k].with_signals({DRIVE: replace(joints, time=joints.time + late)})
    return Fault("joint angles late", ("clock",), (DRIVE,), at)


def offset(rng: Rng, spoiled: Set) -> Fault:
    """A joint zeroed anew by 0.2 to 0.6 deg before the held-out logs."""
    j, shift = int(rng.integers(5)), np.radians(rng.uniform(0.2, 0.6) * rng.choice([-1, 1]))
    at = tuple(range(spoiled.training, len(spoiled.logs)))
    for k in at:
        spoiled.logs[k] = change(spoiled.logs[k], DRIVE, lambda v, t: v + shift * (np.arange(5) == j))
    return Fault("joint zeroed anew", ("zero offset",), (f"{DRIVE}/joint{j + 1}",), at)


def far_off(rng: Rng, spoiled: Set) -> Fault:
    """A joint off by 2.5 to 5 deg in all logs."""
    j, shift = int(rng.integers(5)), np.radians(rng.uniform(2.5, 5) * rng.choice([-1, 1]))
    at = tuple(range(len(spoiled.logs)))
    for k in at:
        spoiled.logs[k] = change(spoiled.logs[k], DRIVE, lambda v, t: v + shift * (np.arange(5) == j))
    return Fault("joint far off", ("zero offset",), (f"{DRIVE}/joint{j + 1}",), at)


def noisy(rng: Rng, spoiled: Set) -> Fault:
    """A sensor with 3 to 10 times its noise."""
    name, at = str(rng.choice([MARKERS, FORCE, *(f"{imu}/specific_force" for imu in IMUS)])), some(rng, spoiled)
    size = rng.uniform(3, 10) * noise_levels(MACHINE)[name]
    for k in at:
        spoiled.logs[k] = change(spoiled.logs[k], name, lambda v, t: v + size * rng.normal(size=v.shape))
    return Fault("noise", ("noise",), (name,), tuple(at))


def missing(rng: Rng, spoiled: Set) -> Fault:
    """A sensor that the training logs, or the held-out ones, lack."""
    sensor, train = str(rng.choice([*IMUS, FORCE, MARKERS])), rng.random() < 0.5
    at = range(spoiled.training) if train else range(spoiled.training, len(spoiled.logs))
    for k in at:
        spoiled.logs[k] = without(spoiled.logs[k], sensor)
    return Fault("sensor missing in a part", ("missing",), (sensor,), tuple(at))


def epoch(rng: Rng, spoiled: Set) -> Fault:
    """One sensor's stamps of another epoch."""
    sensor, at = str(rng.choice([*IMUS, FORCE, MARKERS])), some(rng, spoiled)
    for k in at:
        log = spoiled.logs[k]
        late = {n: replace(log[n], time=log[n].time + 1.7e9) for n in log.signals if n.startswith(sensor)}
        spoiled.logs[k] = log.with_signals(late)
    return Fault("another epoch", ("no time in common",), (sensor,), tuple(at))


def short(rng: Rng, spoiled: Set) -> Fault:
    """A training log of 1 s."""
    k = int(rng.integers(spoiled.training))
    log, lasts = spoiled.logs[k], rng.uniform(0.8, 2)
    cut = {n: picked(s, s.time < s.time[0] + lasts) for n, s in log.signals.items()}
    spoiled.logs[k] = replace(log, signals=cut)
    return Fault("log of a second", ("too short",), ("",), (k,))


def copied(rng: Rng, spoiled: Set) -> Fault:
    """A held-out log that is a training log, or part of one."""
    k, of = int(rng.integers(spoiled.training, len(spoiled.logs))), int(rng.integers(spoiled.training))
    log, share = spoiled.logs[of], rng.uniform(0.3, 1)
    part = {n: picked(s, s.time <= s.time[0] + share * (s.time[-1] - s.time[0])) for n, s in log.signals.items()}
    spoiled.logs[k] = replace(log, name=spoiled.logs[k].name, signals=part)
    return Fault("held out is training", ("copy",), ("",), (k,))


FAULTS = (
    dead, swapped, sign, unit, joint_unit, load, frozen, quantised, outliers, saturated, lost, jump, drift, joints_late,
    offset, far_off, noisy, missing, epoch, short, copied,
)  # fmt: skip
MACHINE = load_machine("boom36")
