"""Spoils what logs mean, in the ways of a bad day on site, and counts how often `check_recordings` names it.

    python scripts/spoil_logs.py FOLDER --commit ID [--sets 500] [--clean 100] [--keep FILE.jsonl] [--seal SEAL]

FOLDER holds cases as the blind check makes them: CASE/train/*.mcap and CASE/holdout/*.mcap. Every set is a case with
its noise drawn anew (the samples' own, scattered a little) and one to three faults of random kind, channel, place and
size, in all logs or in some; the SHA-256 of the commit's id and "spoiled logs" is the seed. A fault is named if a
finding of its kind is at its channel in at least one of its logs; findings at other channels are counted as false.
Clean sets have new noise only. What is done is kept line by line in FILE.jsonl, and a second call goes on. With the
cases' SEAL sets keep their noise and are diagnosed, too, and answers held against the truth.
"""

import argparse
import json
import sys
import time
import traceback
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np
from log_faults import FAULTS, MACHINE, Rng, Set, at

from boom_mj.blind.grading import judge_case
from boom_mj.blind.run import case_logs
from boom_mj.diagnosis.answer import document
from boom_mj.diagnosis.diagnose import diagnose
from boom_mj.errors import LogError
from boom_mj.replay.quality import check_recordings
from boom_mj.sensors import noise_levels
from boom_mj.spreading import spread
from boom_mj.systems.boom.load import checked_data
from boom_mj.systems.boom.system import BoomSystem
from boom_mj.systems.predictor import Predictor

JITTER = 0.3  # of the noise, by which that of a set differs from its case's


def renewed(case: Set, rng: Rng) -> Set:
    """A case with its noise drawn anew, in the steps of its converters."""
    logs = []
    for log in case.logs:
        signals = {}
        for name, level in noise_levels(MACHINE).items():
            if name in log:
                step = 2.0 ** np.floor(np.log2(level / 10))
                more = np.round(JITTER * level * rng.normal(size=log[name].values.shape) / step) * step
                signals[name] = replace(log[name], values=log[name].values + more)
        logs.append(log.with_signals(signals))
    return Set(logs, case.training)


@dataclass(frozen=True)
class Task:
    """One set that is tried: its number, its case, the seed, and what was sealed if it is diagnosed."""

    number: int
    case: Path
    seed: int
    sealed: dict[str, Any] | None

    def __str__(self) -> str:
        return f"set {self.number}"


def tried(task: Task) -> dict:
    """What was done to a set, what was found, and what was answered."""
    clean, number = task.number < 0, abs(task.number) + (10**6 if task.number < 0 else 0)
    rng, count = np.random.default_rng([task.seed, number]), 1 + (number % 5 > 1) + (number % 5 > 3)
    train, held_out = case_logs(task.case)
    spoiled = Set([*train, *held_out], len(train))
    if not task.sealed:  # noise beyond the machine file's would be a gap to a diagnosis
        spoiled = renewed(spoiled, rng)
    kinds = () if clean else rng.choice(len(FAULTS), count, replace=False)
    faults = [FAULTS[kind](rng, spoiled) for kind in kinds]
    names = [str(k) for k in range(len(spoiled.logs))]
    began, trouble, answer = time.process_time(), "", None
    findings: Sequence = ()
    try:
        findings = check_recordings(MACHINE, spoiled.logs, spoiled.training, names).findings
        checked_s = time.process_time() - began
        answer = task.sealed and answered(spoiled, names, task.sealed)
    except Exception:
        checked_s, trouble = time.process_time() - began, traceback.format_exc()
    told = [
        any(f.kind in fault.kinds and int(f.log) in fault.logs and at(f.channel, fault) for f in findings)
        for fault in faults
    ]
    false = [
        f"{f.kind} at {f.channel or 'the log'}"
        for f in findings
        if not any(at(f.channel, fault) or not f.channel or "" in fault.channels for fault in faults)
    ]
    return {
        "number": task.number, "case": task.case.name, "faults": [fault.name for fault in faults], "told": told,
        "false": sorted(set(false)), "cpu_s": checked_s, "traceback": trouble, "answer": answer,
    }  # fmt: skip


def answered(spoiled: Set, names: Sequence[str], sealed: dict[str, Any]) -> dict[str, Any]:
    """The diagnosis of a set, in short."""
    system = BoomSystem(MACHINE)
    try:
        checked = checked_data(system, spoiled.logs, spoiled.training, names)
    except LogError as error:
        return {"refused": str(error), "sealed": " + ".join(e["id"] for e in sealed["effects"]) or "none"}
    said = document(diagnose(Predictor(system, checked.data, threads=1)), checked.names, checked.findings)
    graded = judge_case("", sealed, said)
    return {
        "verdict": said["verdict"], "sealed": graded.truth, "named": graded.answer, "right": graded.right,
        "held": graded.held, "gap": said["gap"], "probability": graded.probability, "reason": graded.reason,
    }  # fmt: skip


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, nargs="+")
    parser.add_argument("--sets", type=int, default=500)
    parser.add_argument("--clean", type=int, default=100)
    parser.add_argument("--commit", required=True, help="that is tried")
    parser.add_argument("--keep", type=Path, default=Path("spoiled.jsonl"))
    parser.add_argument("--seal", type=Path, help="truths of the cases: every set is diagnosed as well")
    parser.add_argument("--jobs", type=int, default=1)
    options = parser.parse_args()
    cases = sorted(path for root in options.folder for path in root.iterdir() if (path / "train").is_dir())
    truths = json.loads(options.seal.read_text())["cases"] if options.seal else {}
    if truths:  # only of what the library holds something can be named
        cases = [case for case in cases if truths[case.name]["class"] in ("single", "none")]
    rows = [json.loads(line) for line in options.keep.read_text().splitlines()] if options.keep.exists() else []
    done = {row["number"] for row in rows}
    numbers = [*range(-options.clean, 0), *range(options.sets)]
    order = sorted(numbers, key=lambda n: (n % 7, n))  # clean and spoiled sets in turn
    seed = int.from_bytes(sha256(f"{options.commit}spoiled logs".encode()).digest())
    cases = {number: cases[number % len(cases)] for number in order}
    tasks = [Task(n, cases[n], seed, truths.get(cases[n].name)) for n in order if n not in done]
    for finished in spread(tried, tasks, options.jobs):
        rows.append(finished.result())
        with options.keep.open("a") as stream:
            stream.write(json.dumps(rows[-1]) + "\n")
        if len(rows) % 20 == 0:
            print(f"{len(rows)} of {len(numbers)} sets", file=sys.stderr)
    rows = [row for row in rows if row["number"] in set(numbers)]
    print(table(rows), *([answers(rows)] if truths else []), sep="\n")
    return 1 if any(row["traceback"] for row in rows) else 0


def answers(rows: list[dict]) -> str:
    """What was answered about sets, by whether something was wrong with them and with the machine, as Markdown."""
    lines = ["", "| sets | tried | refused | right | held | named wrongly | so at more than 0.5 |", "|" + "---|" * 7]
    for spoiled in (False, True):
        for healthy in (True, False):
            every = [r["answer"] for r in rows if r["answer"] and bool(r["faults"]) == spoiled]
            tried_ = [a for a in every if (a["sealed"] == "none") == healthy]
            of = [a for a in tried_ if "refused" not in a]
            wrong = [a for a in of if not a["right"] and a["verdict"] in ("explained", "ambiguous", "partial")]
            sure = [a for a in wrong if (a["probability"] or 0) > 0.5]
            name = f"{'spoiled' if spoiled else 'clean'}, {'nothing' if healthy else 'one effect'}"
            right, held = (sum(a[key] for a in of) for key in ("right", "held"))
            counts = len(tried_), len(tried_) - len(of), right, held, len(wrong), len(sure)
            lines.append(f"| {name} | " + " | ".join(map(str, counts)) + " |")
    return "\n".join(lines)


def table(rows: list[dict]) -> str:
    """What was found, as Markdown."""
    tried_, told = Counter(), Counter()
    for row in rows:
        tried_.update(row["faults"])
        told.update(name for name, good in zip(row["faults"], row["told"]) if good)
    lines = ["| fault | tried | named at its channel |", "|---|---|---|"]
    lines += [f"| {name} | {count} | {told[name]} |" for name, count in sorted(tried_.items())]
    lines.append(f"| all | {tried_.total()} | {told.total()} ({100 * told.total() / max(tried_.total(), 1):.1f} %) |")
    spoiled, clean = [r for r in rows if r["faults"]], [r for r in rows if not r["faults"]]
    false = Counter(text.partition(" at ")[0] for row in spoiled for text in row["false"])
    lines += [
        "",
        f"- spoiled sets: {len(spoiled)}; all faults named in {sum(all(r['told']) for r in spoiled)} of them",
        f"- spoiled sets with a finding elsewhere: {sum(bool(r['false']) for r in spoiled)} "
        f"({', '.join(f'{kind} {count}' for kind, count in false.most_common()) or 'none'})",
        f"- clean sets: {len(clean)}, with a finding: {sum(bool(r['false']) for r in clean)}",
        f"- tracebacks: {sum(bool(r['traceback']) for r in rows)}",
        f"- CPU seconds a set: {np.mean([r['cpu_s'] for r in rows]):.2f}",
    ]
    return "\n".join(lines)


if __name__ == "__main__":
    sys.exit(main())
