"""Spoils one sensor, or a few seconds of a log, in ways that show only beside an explanation, and diagnoses the rest.

    python scripts/outliers.py CASES --commit ID [--sets 12] [--jobs 2] [--keep FILE.jsonl] > table.md

CASES holds CASE/train, CASE/holdout and CASE/truth.json, the one effect of a machine or none. A set is a case with one
fault of random kind, place and size: a knock of 2 to 4 s in one log, at one sensor or all; a gain; a wandering channel;
an IMU that is late against the others. The seed is the SHA-256 of the commit's id and "outliers". Counted are outliers
that are named at their sensor, sets of which the effect is named and no other (of a sound machine none), and sizes of
effects that are in their intervals. Results are kept line by line in FILE.jsonl, and a second call goes on.
"""

import argparse
import json
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np
from log_faults import COMMAND, DRIVE, FORCE, IMUS, MARKERS, Fault, Rng, Set, at, change, noise_levels

from boom_mj.blind.run import case_logs
from boom_mj.diagnosis import diagnose, document
from boom_mj.machine import load_machine
from boom_mj.spreading import spread
from boom_mj.systems.boom.load import checked_data
from boom_mj.systems.boom.system import BoomSystem
from boom_mj.systems.predictor import Predictor

MACHINE = load_machine("boom36")
SENSORS = (*IMUS, *(f"{MARKERS}/marker{k}" for k in range(1, 13)), *(f"{FORCE}/cylinder{k}" for k in (2, 3)))


def columns(spoiled: Set, device: str) -> list[tuple[str, list[int]]]:
    """Signals of a sensor, and which of their columns are its own."""
    own = [(n, s) for n, s in spoiled.logs[0].signals.items() if n not in (DRIVE, COMMAND)]
    found = [(n, [k for k, c in enumerate(s.channels) if f"{n}/{c}/".startswith(f"{device}/")]) for n, s in own]
    return [(name, numbers) for name, numbers in found if numbers]


def everywhere(spoiled: Set, device: str, logs: range, add: Callable[[float, Any, Any], Any]) -> None:
    """Change what a sensor says in some logs: `add` of its noise, values and times."""
    for name, numbers in columns(spoiled, device):
        level = noise_levels(MACHINE)[name]
        for k in logs:

            def changed(values: Any, time: Any, numbers: list[int] = numbers, level: Any = level) -> Any:
                for column in numbers:
                    values[:, column] = add(level[column], values[:, column], time)
                return values

            spoiled.logs[k] = change(spoiled.logs[k], name, changed)


def knock(rng: Rng, spoiled: Set) -> Fault:
    """One log shaken for some seconds, at one sensor or at all."""
    k, devices = int(rng.integers(len(spoiled.logs))), SENSORS if rng.random() < 0.3 else (str(rng.choice(SENSORS)),)
    lasts, size, pitch = rng.uniform(2, 4), rng.uniform(20, 100), rng.uniform(0.5, 3)
    began = rng.uniform(0.2, 0.7) * np.ptp(spoiled.logs[k][DRIVE].time)
    for device in devices:
        everywhere(
            spoiled, device, range(k, k + 1),
            lambda n, v, t: v + size * n * np.sin(2 * np.pi * pitch * t) * ((t > began) & (t < began + lasts)),
        )  # fmt: skip
    return Fault("knock", ("outlying",), devices if len(devices) == 1 else ("",), (k,))


def gain(rng: Rng, spoiled: Set) -> Fault:
    """An IMU that reads too little or too much."""
    device, factor = str(rng.choice(IMUS)), rng.choice([rng.uniform(0.6, 0.85), rng.uniform(1.2, 1.5)])
    everywhere(spoiled, device, range(len(spoiled.logs)), lambda n, v, t: factor * v)
    return Fault("gain", ("outlying",), (device,), tuple(range(len(spoiled.logs))))


def wandering(rng: Rng, spoiled: Set) -> Fault:
    """A sensor that drifts to and fro."""
    device, size, period = str(rng.choice(SENSORS)), rng.uniform(20, 60), rng.uniform(15, 60)
    everywhere(
        spoiled, device, range(len(spoiled.logs)), lambda n, v, t: v + size * n * np.sin(2 * np.pi * t / period + 1)
    )
    return Fault("wandering", ("outlying",), (device,), tuple(range(len(spoiled.logs))))


def late(rng: Rng, spoiled: Set) -> Fault:
    """One IMU late against the others."""
    device, delay = str(rng.choice(IMUS)), rng.uniform(0.05, 0.3)
    everywhere(spoiled, device, range(len(spoiled.logs)), lambda n, v, t: np.interp(t - delay, t, v))
    return Fault("one IMU late", ("outlying",), (device,), tuple(range(len(spoiled.logs))))


FAULTS = (knock, gain, wandering, late)


@dataclass(frozen=True)
class Task:
    """One set: its number, its case, the seed."""

    number: int
    case: Path
    seed: int

    def __str__(self) -> str:
        return f"set {self.number}"


def tried(task: Task) -> dict[str, Any]:
    """What was done to a set and what was answered."""
    rng = np.random.default_rng([task.seed, task.number])
    train, held_out = case_logs(task.case)
    spoiled = Set([*train, *held_out], len(train))
    fault = FAULTS[task.number % len(FAULTS)](rng, spoiled)
    names, began = [log.name for log in spoiled.logs], time.process_time()
    checked = checked_data(BoomSystem(MACHINE), spoiled.logs, spoiled.training, names)
    said = document(diagnose(Predictor(BoomSystem(MACHINE), checked.data, threads=1)), checked.names, checked.findings)
    places = [f"{row['kind']} at {row['channel'] or 'the log'}" for row in said["data"]]
    spoilt = {names[k] for k in fault.logs}
    told = [row for row in said["data"] if row["kind"] in fault.kinds and row["log"] in spoilt]
    true = json.loads((task.case / "truth.json").read_text())["effects"]
    return {
        "number": task.number, "case": task.case.name, "fault": f"{fault.name}: {fault.channels[0] or 'all sensors'}",
        "found": any(at(row["channel"], fault) for row in told),
        "data": sorted(set(places)), "verdict": said["verdict"], "truth": [e for e in true if e["id"] != "none"],
        "effects": said["effects"], "with": said["with_outliers"] and said["with_outliers"]["verdict"],
        "sentence": said["sentence"], "cpu_s": time.process_time() - began,
    }  # fmt: skip


def table(rows: list[dict[str, Any]]) -> str:
    """Set by set, as Markdown."""
    lines = ["| set | case | fault | found | truth | verdict | named | CPU s |", "|" + "---|" * 8]
    good, found, held = 0, 0, list[bool]()
    for row in sorted(rows, key=lambda row: row["number"]):
        true, named = ([(e["id"], e["location"]) for e in row[key]] for key in ("truth", "effects"))
        good, found = good + (true == named), found + row["found"]
        held += [
            size["low"] <= true_one["magnitude"][name] <= size["high"]
            for true_one, one in zip(row["truth"], row["effects"])
            if true == named
            for name, size in one["parameters"].items()
            if name in true_one["magnitude"]
        ]
        words = (" + ".join(one for one, _ in effects) or "none" for effects in (true, named))
        cells = (row["case"], row["fault"], ", ".join(row["data"]) or "-", next(words), row["verdict"], next(words))
        lines.append(f"| {row['number']} | {' | '.join(cells)} | {row['cpu_s']:.0f} |")
    counts = f"Faults found at their sensor: {found} of {len(rows)}; effects named, and no other: {good}"
    return "\n".join([*lines, "", f"{counts}; sizes in their intervals: {sum(held)} of {len(held)}."])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--commit", required=True, help="that is tried")
    parser.add_argument("--sets", type=int, default=12)
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--keep", type=Path, default=Path("outliers.jsonl"))
    options = parser.parse_args()
    cases = sorted(path.parent for path in options.folder.glob("*/truth.json"))
    seed = int.from_bytes(sha256(f"{options.commit}outliers".encode()).digest())
    rows = [json.loads(line) for line in options.keep.read_text().splitlines()] if options.keep.exists() else []
    done = {row["number"] for row in rows}
    tasks = [Task(n, cases[(n // len(FAULTS) + n) % len(cases)], seed) for n in range(options.sets) if n not in done]
    for finished in spread(tried, tasks, options.jobs):
        rows.append(finished.result())
        with options.keep.open("a") as stream:
            stream.write(json.dumps(rows[-1]) + "\n")
        print(f"{len(rows)} of {options.sets} sets", file=sys.stderr)
    print(table(rows))


if __name__ == "__main__":
    main()
