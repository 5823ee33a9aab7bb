"""Since when, what, and how large: series of logs of machines that change, watched; prints tables.

    python scripts/watching.py --commit ID [--series 20] [--healthy 10] [--jobs 2] [--keep FILE.jsonl]

Every machine is drawn as it was built, records three logs when it was well, and twelve later; two motions take turns.
One effect of the library is there from the start of a random log, enters within one (two simulations, one cut onto the
other), or grows from log to log to what was drawn; healthy series have none. The SHA-256 of the commit's id and
"watching" is the seed. What is done is kept line by line in FILE.jsonl, and a second call goes on.
"""

import argparse
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from healthy_first import all_rows, changed, entropy_of, in_words, stored

from boom_mj.blind.detectability import Detectability
from boom_mj.blind.grading import errors_of
from boom_mj.blind.plant import AS_BUILT, nuisances, true_plant
from boom_mj.blind.sampling import draw, known_effects
from boom_mj.diagnosis.candidate import Candidate
from boom_mj.diagnosis.watch import watch
from boom_mj.effects import Effect
from boom_mj.errors import EquilibriumError, SimulationError
from boom_mj.machine import load_machine
from boom_mj.recording import Recording
from boom_mj.sensors import record
from boom_mj.simulation import CATALOGUE, run_experiment
from boom_mj.systems.boom.system import BoomSystem

MACHINE = load_machine("boom36")
MOTIONS = [CATALOGUE[name] for name in ("release_bow_vertical", "sweep")]
WELL, LOGS = 3, 12  # logs of the machine when it was well, and later
WAYS = ("from a log on", "within a log", "growing")
SEEN = 0.25  # deviations of the noise: what an oracle sees is there


@dataclass(frozen=True)
class Task:
    """A series: its number, the way its effect comes (none if empty), and the entropy of the set."""

    number: int
    way: str
    names: tuple[str, ...]
    entropy: tuple[int, ...]

    def __str__(self) -> str:
        return f"series {self.number}"


def tried(task: Task) -> dict[str, Any]:
    """Truth and answer of one series."""
    rng = np.random.default_rng((*task.entropy, task.number))
    own = nuisances(MACHINE, rng, AS_BUILT)
    eye = Detectability(MACHINE, MOTIONS)
    while True:
        effect = drawn(task, rng, eye)
        first, moment = int(rng.integers(2, LOGS - 2)), float(rng.uniform(8, 22))
        try:
            there = {k: sizes(effect, task.way, first, k) for k in range(first, LOGS)} if effect else {}
            logs = [recorded(own, there.get(k), rng, k, k + WELL) for k in range(-WELL, LOGS)]
            if task.way == WAYS[1]:
                before = recorded(own, None, rng, first, first + WELL)
                logs[WELL + first] = cut(before, logs[WELL + first], moment)
        except (EquilibriumError, SimulationError):
            continue  # the coarse model stood it, the fine one does not
        break
    logs = stored(logs)
    began = time.process_time()
    found = watch(BoomSystem(MACHINE), logs[:WELL], logs[WELL:]).document()
    truth = {
        "way": task.way,
        "effects": [{"id": e.id, "location": e.location, "parameters": free(e)} for e in there.values()][-1:],
        "sizes": [free(there[k]) if k in there else None for k in range(LOGS)],
        "first": next((k for k, e in there.items() if eye.visibility([e]) > SEEN), first) if there else None,
        "moment": moment if task.way == WAYS[1] else 0.0,
    }
    return {"number": task.number, "truth": truth, "answer": found, "cpu_s": time.process_time() - began}


def drawn(task: Task, rng: np.random.Generator, eye: Detectability) -> Effect | None:
    """The effect in the end; of one that grows, with one size."""
    for name in task.names:
        effect, _ = draw(name, rng, lambda e: eye.visibility(e))
        alone = len(effect.free(effect.site)) == 1 or task.way != WAYS[2]
        if alone and eye.visibility([effect]) > SEEN:
            return effect
    return None


def sizes(effect: Effect, way: str, first: int, log: int) -> Effect:
    """An effect as it is in a log."""
    if way != WAYS[2]:
        return effect
    whole = Candidate((effect,))
    return whole.at((log - first + 1) / (LOGS - first) * whole.start)[0]


def free(effect: Effect) -> dict[str, float]:
    """Its sizes."""
    return {name: effect.values[name] for name in effect.free(effect.site)}


def recorded(own: Sequence[Effect], effect: Effect | None, rng: np.random.Generator, log: int, turn: int) -> Recording:
    """A log of the machine as it was built, perhaps with an effect."""
    experiment = MOTIONS[turn % len(MOTIONS)]
    plant = true_plant(MACHINE, changed(own, [effect] if effect else []))
    found = record(run_experiment(plant, experiment), experiment, rng)
    return replace(found, name=f"well{log + WELL + 1}" if log < 0 else f"log{log + 1:02d}")


def cut(before: Recording, after: Recording, moment: float) -> Recording:
    """One recording up to a moment, another of the same motion from then on."""
    joined = {}
    for name, signal in after.signals.items():
        old = before.signals[name]
        early, late = old.time < moment, signal.time >= moment
        parts = (
            np.concatenate([old.time[early], signal.time[late]]),
            np.concatenate([old.values[early], signal.values[late]]),
        )
        joined[name] = replace(signal, time=parts[0], values=parts[1])
    return replace(after, signals=joined)


def table(rows: list[dict[str, Any]]) -> str:
    """What was told of all, and series by series, as Markdown."""
    lines = ["| series | " + " | ".join([*WAYS, "healthy"]) + " |", "|---" * (len(WAYS) + 2) + "|"]
    kinds = [[judged(r) for r in rows if r["truth"]["way"] == way] for way in (*WAYS, "")]

    def line(name: str, *values: str) -> None:
        lines.append(f"| {name} | " + " | ".join(values) + " |")

    line("number", *(str(len(kind)) for kind in kinds))
    line("series with a false alarm before", *(str(sum(j["early"] > 0 for j in kind)) for kind in kinds))
    line(
        "logs called changed before",
        *(f"{sum(j['early'] for j in k)} of {sum(j['well'] for j in k)}" for k in kinds),
    )
    line("alarm", *(str(sum(j["delay"] is not None for j in kind)) for kind in kinds[:3]), "-")
    delays = [[j["delay"] for j in kind if j["delay"] is not None] for kind in kinds[:3]]
    line("delay, logs, mean and worst", *(f"{np.mean(d):.1f}, {max(d)}" if d else "-" for d in delays), "-")
    line("effect and place named", *(str(sum(j["right"] for j in kind)) for kind in kinds[:3]), "-")
    held = [[abs(e) <= 1 for j in kind for e in j["errors"]] for kind in kinds[:3]]
    line("sizes of single logs in their intervals", *(f"{sum(h)} of {len(h)}" for h in held), "-")
    line("CPU s, median", *(f"{np.median([j['cpu_s'] for j in kind]):.0f}" if kind else "-" for kind in kinds))
    lines += ["", "| series | truth | since | found since | verdict | answer |", "|---" * 6 + "|"]
    for row in sorted(rows, key=lambda r: r["number"]):
        truth, answer = row["truth"], row["answer"]
        true = f"{truth['way']}: {', '.join(map(in_words, truth['effects']))}" if truth["effects"] else "healthy"
        when = f"log {truth['first'] + 1}, {truth['moment']:.0f} s" if truth["effects"] else "-"
        since = f"{answer['since']['log']}, {answer['since']['time_s']:.0f} s" if answer["since"] else "-"
        said = ", ".join(map(in_words, answer["effects"])) or "-"
        lines.append(f"| {row['number']} | {true} | {when} | {since} | {answer['verdict']} | {said} |")
    return "\n".join(lines)


def judged(row: dict[str, Any]) -> dict[str, Any]:
    """One series: false alarms, the delay of the alarm, whether the cause is right, and errors of its sizes."""
    truth, answer = row["truth"], row["answer"]
    called = [k for k, log in enumerate(answer["logs"]) if log["changed"]]
    there = [k for k, size in enumerate(truth["sizes"]) if size]
    entered = there[0] if there else LOGS
    late = [k for k in called if k >= entered]
    places = [[(e["id"], e["location"]) for e in one["effects"]] for one in (truth, answer)]
    right = bool(there) and places[0] == places[1] and answer["verdict"] != "unexplained"
    errors = [
        error
        for k in there[truth["moment"] > 0 :]
        for one in answer["logs"][k]["effects"]
        for error in errors_of(truth["sizes"][k], one["parameters"])
    ]
    return {
        "early": sum(k < entered for k in called),
        "well": entered,
        "delay": max(0, late[0] - truth["first"]) if late else None,
        "right": right,
        "errors": errors if right else [],
        "cpu_s": row["cpu_s"],
    }


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--commit", required=True, help="that is tried")
    parser.add_argument("--series", type=int, default=20, help="with an effect")
    parser.add_argument("--healthy", type=int, default=10, help="without one")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--keep", type=Path, default=Path("watching.jsonl"))
    options = parser.parse_args()
    entropy = entropy_of(options.commit, "watching")
    deck = [str(name) for name in np.random.default_rng(entropy).permutation(known_effects())]
    ways = [WAYS[k % len(WAYS)] for k in range(options.series)]
    for k in range(options.healthy):
        ways.insert(3 * k + 2, "")  # a run that is stopped has some of each
    tasks = [Task(k, way, tuple(map(str, np.roll(deck, -k))) if way else (), entropy) for k, way in enumerate(ways)]
    rows = all_rows(tried, tasks, options.keep, options.jobs)
    print(table(rows))
    return 0


if __name__ == "__main__":
    sys.exit(main())
