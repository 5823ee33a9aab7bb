"""What `logs check` says of the spoiled logs of an ordinary bad day, row by row: a table of docs/results.

    python scripts/spoiled_rows.py CASE [--only WORD]

CASE is a folder of an independent machine (train/*.mcap, holdout/*.mcap). Every row spoils its logs in one way that was
met on real ones, by hand and not at random; a sentence a row is shown, with how many more there are.
"""

import argparse
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
from log_faults import COMMAND, DRIVE, FORCE, MACHINE, MARKERS, Logs, change, picked, without

from boom_mj.blind.run import case_logs
from boom_mj.errors import BoomError
from boom_mj.recording import Recording
from boom_mj.replay.quality import check_recordings

Array = np.ndarray
Spoil = Callable[[Logs, int], Logs]
RNG = np.random.default_rng(0)


def each(edit: Callable[[Recording], Recording], training: bool = True, held_out: bool = True) -> Spoil:
    """The same done to all logs of a part."""

    def spoil(logs: Logs, count: int) -> Logs:
        return [edit(log) if (training if k < count else held_out) else log for k, log in enumerate(logs)]

    return spoil


def one(edit: Callable[[Recording], Recording], index: int = 0) -> Spoil:
    return lambda logs, count: [edit(log) if k == index else log for k, log in enumerate(logs)]


def values(name: str, edit: Callable[[Array, Array], Array]) -> Callable[[Recording], Recording]:
    return lambda log: change(log, name, edit) if name in log else log


def joint(number: int, degrees: float) -> Callable[[Recording], Recording]:
    return values(DRIVE, lambda v, t: v + np.radians(degrees) * (np.arange(5) == number - 1))


def of_imu(imu: str, edit: Callable[[Array, Array], Array]) -> Callable[[Recording], Recording]:
    names = [f"{imu}/{quantity}" for quantity in ("specific_force", "angular_rate")]
    return lambda log: values(names[0], edit)(values(names[1], edit)(log))


def swapped_imus(log: Recording) -> Recording:
    pairs = [
        (f"imu/link{a}/{q}", f"imu/link{b}/{q}")
        for a, b in ((3, 4), (4, 3))
        for q in ("specific_force", "angular_rate")
    ]
    return log.with_signals({to: replace(log[of], frame=log[to].frame) for to, of in pairs})


def frozen(log: Recording) -> Recording:
    rate = np.abs(np.gradient(log[COMMAND].values, log[COMMAND].time, axis=0))
    moment, number = np.unravel_index(np.argmax(rate), rate.shape)
    start = log[COMMAND].time[moment] - log[DRIVE].time[0] - 1.5

    def still(v: Array, t: Array) -> Array:
        inside = (t >= start) & (t <= start + 3)
        v[inside, number] = v[np.argmax(inside), number]
        return v

    return change(log, DRIVE, still)


def shifted(names: Callable[[str], bool], seconds: float) -> Callable[[Recording], Recording]:
    return lambda log: log.with_signals(
        {n: replace(s, time=s.time + seconds) for n, s in log.signals.items() if names(n)}
    )


def lost(log: Recording) -> Recording:
    found = {}
    for name, signal in log.signals.items():
        if not name.startswith("joint"):
            t = signal.time - signal.time[0]
            found[name] = picked(signal, (RNG.random(len(t)) > 0.05) & ~((t > 12) & (t < 13.5)))
    return log.with_signals(found)


def cut(seconds: float, since: float = 0.0) -> Callable[[Recording], Recording]:
    def edit(log: Recording) -> Recording:
        inside = {
            n: (s.time - s.time[0] >= since) & (s.time - s.time[0] < since + seconds) for n, s in log.signals.items()
        }
        return replace(log, signals={n: picked(s, inside[n]) for n, s in log.signals.items()})

    return edit


def copied(logs: Logs, count: int) -> Logs:
    return [*logs[:count], replace(logs[0], name="again"), *logs[count + 1 :]]


def moving(log: Recording) -> bool:
    return bool(np.ptp(log[COMMAND].values, axis=0).max() > 0.05)


def anywhere(edit: Callable[[Recording], Recording]) -> Spoil:
    """In the first training log that moves."""
    return lambda logs, count: one(edit, next(k for k in range(count) if moving(logs[k])))(logs, count)


def saturated(v: Array, t: Array) -> Array:
    return np.clip(v, -9.8, 9.8)


def spikes(v: Array, t: Array) -> Array:
    return v + (RNG.random(v.shape) < 0.02) * RNG.choice([-0.5, 0.5], v.shape)


def step(v: Array, t: Array) -> Array:
    size = np.radians(0.1)
    return size * np.round(v / size)


def stuck(v: Array, t: Array) -> Array:
    v[t > 15] = v[np.argmax(t > 15)]
    return v


ROWS: tuple[tuple[str, Spoil], ...] = (
    ("encoder of joint 3 off by a constant 3 deg", each(joint(3, 3.0))),
    ("joint 2 zeroed anew by 0.3 deg before the held-out logs", each(joint(2, 0.3), training=False)),
    ("joint 3 by 0.4 deg", each(joint(3, 0.4), training=False)),
    ("joint 4 by 0.5 deg", each(joint(4, 0.5), training=False)),
    ("joint 5 by -0.3 deg", each(joint(5, -0.3), training=False)),
    ("markers missing in training", each(lambda log: without(log, MARKERS), held_out=False)),
    ("IMU of link 4 dead (zeros)", each(of_imu("imu/link4", lambda v, t: 0 * v))),
    ("IMU of link 4 stuck from 15 s", each(of_imu("imu/link4", stuck))),
    ("plugs of the IMUs of links 3 and 4 swapped", each(swapped_imus)),
    ("y of an accelerometer turned", each(values("imu/link4/specific_force", lambda v, t: v * [1, -1, 1]))),
    ("z (sideways) of an accelerometer turned", each(values("imu/link4/specific_force", lambda v, t: v * [1, 1, -1]))),
    ("cylinder forces in kN", each(values(FORCE, lambda v, t: v / 1000))),
    ("markers in mm", each(values(MARKERS, lambda v, t: v * 1000))),
    ("load in kN", each(values("load", lambda v, t: v / 1000))),
    ("load missing", each(lambda log: without(log, "load"))),
    ("joint 1 in degrees", each(values(DRIVE, lambda v, t: v * [180 / np.pi, 1, 1, 1, 1]))),
    ("a joint angle frozen for 3 s", anywhere(frozen)),
    ("joint angles in steps of 0.1 deg", each(values(DRIVE, step))),
    ("2 % of the markers' samples 0.5 m off", each(values(MARKERS, spikes))),
    ("accelerometer saturated at 9.8 m/s^2", each(values("imu/link5/specific_force", saturated))),
    ("5 % of messages lost and a hole of 1.5 s in all sensors but the joints", one(lost)),
    ("joint angles begin 2 ms after the other sensors", each(shifted(lambda n: not n.startswith("joint"), -0.002))),
    ("joint angles begin 0.15 s after the other sensors", each(lambda log: log.with_signals({
        DRIVE: picked(log[DRIVE], log[DRIVE].time > log[DRIVE].time[0] + 0.15)}))),
    ("joint angles 0.3 s late", each(shifted(lambda n: n == DRIVE, 0.3))),
    ("a training log of 1 s", one(cut(1.0))),
    ("all logs 1 s at rest", each(cut(1.0))),
    ("a held-out log that is a training log", copied),
    ("stamps of one IMU of another epoch", each(shifted(lambda n: n.startswith("imu/link3"), 1.7e9))),
    ("an IMU missing in training", each(lambda log: without(log, "imu/link5"), held_out=False)),
)  # fmt: skip


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("case", type=Path)
    parser.add_argument("--only", default="", help="rows that hold a word")
    parser.add_argument("--other", type=Path, help="a case of another state of the machine")
    given = parser.parse_args()
    train, held_out = case_logs(given.case)
    rows = list(ROWS)
    if given.other:
        other = case_logs(given.other)[1]
        rows.append(("training logs of one machine, held-out ones of another", lambda logs, n: [*logs[:n], *other]))
    print("| spoiled logs | findings | what is said of the first |\n|---|---|---|")
    for name, spoil in rows:
        if given.only in name:
            logs = spoil([*train, *held_out], len(train))
            print(f"| {name} | {' | '.join(said(logs, len(train)))} |", flush=True)
    return 0


def said(logs: Logs, training: int) -> tuple[str, str]:
    """Kinds of findings with how many, and the first sentence."""
    names = [f"{log.name}" + ("" if k < training else " (held out)") for k, log in enumerate(logs)]
    try:
        findings = check_recordings(MACHINE, logs, training, names).findings
    except BoomError as error:
        return "refused", str(error)
    kinds = [f.kind for f in findings]
    counted = ", ".join(f"{kind} {kinds.count(kind)}" for kind in dict.fromkeys(kinds)) or "none"
    if not findings:
        return counted, ""
    first = findings[0]
    mends = f"; `{first.repair.line}`" if first.repair else ""
    return counted, first.sentence.replace("|", "/") + mends


if __name__ == "__main__":
    sys.exit(main())
