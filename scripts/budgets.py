"""Booms as built with none to five causes: which are named, how large, and what each takes of the gap; prints tables.

    python scripts/budgets.py --commit ID [--machines 60] [--jobs 2] [--keep FILE.jsonl]

As many machines have no cause as have two, three, four and five. Each is drawn as it was built and records the short
suite twice, when it was well and later with its causes, and is diagnosed with `--healthy` and `--most 5`; when all are
done, every other one that has any once more without the first of them in the library. True shares are the plant's,
causes left out of it in all ways, in the metric of the answer: its noise, model error and nuisances. The SHA-256 of the
commit's id and "budgets" is the seed. What is done is kept line by line in FILE.jsonl and FILE.withheld.jsonl, and a
second call goes on.
"""

import argparse
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import count, cycle, islice
from pathlib import Path
from typing import Any

import numpy as np
from healthy_first import EXPERIMENTS, MACHINE, Logs, all_rows, changed, entropy_of, in_words, recorded

from boom_mj.blind.boom_bench import SHORT
from boom_mj.blind.figures import wilson
from boom_mj.blind.grading import errors_of
from boom_mj.blind.plant import true_plant
from boom_mj.blind.sampling import known_effects
from boom_mj.diagnosis.answer import document
from boom_mj.diagnosis.budget import metric, shapley, subsets_of
from boom_mj.diagnosis.conclusion import Diagnosis
from boom_mj.diagnosis.diagnose import diagnose
from boom_mj.diagnosis.healthy import as_built
from boom_mj.diagnosis.linearisation import Linearisation
from boom_mj.effects import Effect, make_effect
from boom_mj.sensors import record, true_angles
from boom_mj.simulation import Experiment, Plant, Trajectory, run, step_times
from boom_mj.systems.boom.load import checked_data
from boom_mj.systems.boom.system import BoomSystem
from boom_mj.systems.predictor import Predictor, dataset_of
from boom_mj.systems.system import System

COUNTS = 0, 2, 3, 4, 5  # causes
WITHHELD = 2  # one of so many machines loses a cause of the library
STEP = 1.0  # of the diagnosis, of the plant that tells shares; 0.4 told the same to 0.0003
CLOSE = 0.05  # a share and the true one


@dataclass(frozen=True)
class Task:
    """A machine: its number, ids of its causes, and the entropy of the set."""

    number: int
    ids: tuple[str, ...]
    entropy: tuple[int, ...]

    def __str__(self) -> str:
        return f"machine {self.number}"


def tasks(machines: int, entropy: tuple[int, ...]) -> list[Task]:
    """Effects in one random order after another, none twice in a machine."""
    rng, found = np.random.default_rng(entropy), []
    deck = (str(name) for _ in count() for name in rng.permutation(known_effects()))
    for number, wanted in enumerate(islice(cycle(COUNTS), machines)):
        ids: dict[str, None] = {}
        while len(ids) < wanted:
            ids[next(deck)] = None
        found.append(Task(number, tuple(ids), entropy))
    return found


def tried(task: Task) -> dict[str, Any]:
    """Truth and answers of one machine."""
    healthy, later, truth, own = recorded(task.ids, np.random.default_rng((*task.entropy, task.number)))
    effects = [make_effect(e["id"], {**e["location"], **e["parameters"]}) for e in truth["effects"]]
    began = time.process_time()
    found, answer = answered(as_built(BoomSystem(MACHINE), healthy), later)
    row = {"number": task.number, "truth": truth, "answer": answer, "cpu_s": time.process_time() - began}
    if effects and found.best:
        row["shares"] = true_shares(own, effects, found.best.model)
    return row


def tried_without(task: Task) -> dict[str, Any]:
    """The answer where the library lacks the first cause of one machine."""
    healthy, later, truth, _ = recorded(task.ids, np.random.default_rng((*task.entropy, task.number)))
    began = time.process_time()
    _, answer = answered(as_built(BoomSystem(MACHINE), healthy), later, (truth["effects"][0]["id"],))
    return {"number": task.number, "answer": answer, "cpu_s": time.process_time() - began}


def answered(built: System, later: Logs, without: Sequence[str] = ()) -> tuple[Diagnosis, dict[str, Any]]:
    """The diagnosis of later logs, and the same in short."""
    checked = checked_data(BoomSystem(MACHINE), later, len(SHORT.train), built=built)
    found = diagnose(Predictor(built, checked.data, threads=1), without, most=max(COUNTS))
    said = document(found, checked.names, checked.findings)
    return found, {name: said[name] for name in ("verdict", "effects", "suspect", "gap", "budget", "remainder")}


def true_shares(own: Sequence[Effect], effects: Sequence[Effect], model: Linearisation) -> list[float]:
    """What each cause takes off the held-out mean square when the plant is without it, as `Budget` says of the model.

    Args:
        own: how the machine was built.
        model: that whitens, and holds the nuisances.
    """

    def told(subset: Sequence[int]) -> np.ndarray:
        there = changed(own, [effects[k] for k in subset])
        plant = true_plant(MACHINE, there, STEP)
        logs = [record(moved(plant, there, e), e) for e in EXPERIMENTS]
        return dataset_of(model.system, logs, len(SHORT.train)).measured

    subsets, metric_of = subsets_of(len(effects)), metric(model)
    whole = told(subsets[-1])

    def square(subset: Sequence[int]) -> float:
        seen = metric_of(tuple(effects[k] for k in subset))
        left = seen.clean(seen.noise.white(whole - told(subset)))
        return 1 + float(np.mean(left[model.data.held_out] ** 2))

    squares = np.array([[square(subset) for subset in subsets]])
    at = {subset: k for k, subset in enumerate(subsets)}
    return [float(shapley(squares, at, k, len(effects))[0] / squares[0, 0]) for k in range(len(effects))]


def moved(plant: Plant, effects: Sequence[Effect], plan: Experiment) -> Trajectory:
    """A plant whose joints read what an experiment asks for."""
    time = step_times(plant, plan.duration)
    return run(plant, true_angles(effects, plan.joint_path(time)[0]), plan.tip_force(time))


def with_withheld(rows: Sequence[dict[str, Any]], without: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """Rows of machines with what is said of those that lack a cause of the library."""
    said = {row["number"]: {"withheld": row["answer"]} for row in without}
    return [row | said.get(row["number"], {}) for row in rows]


def same(one: dict[str, Any], other: dict[str, Any]) -> bool:
    """Effect and place."""
    return bool(one["id"] == other["id"] and one["location"] == other["location"])


def hits(row: dict[str, Any]) -> list[tuple[int, dict[str, Any]]]:
    """Numbers of the true causes that are named at their places, and how."""
    true = enumerate(row["truth"]["effects"])
    return [(k, named) for k, cause in true for named in row["answer"]["effects"] if same(cause, named)]


def share_errors(row: dict[str, Any]) -> list[float]:
    """Of the causes that are named."""
    said = row["answer"]["budget"]
    return [one["share"] - row["shares"][k] for k, named in hits(row) for one in said if same(one, named)]


def size_errors(row: dict[str, Any]) -> list[float]:
    """In units of the intervals, of the causes that are named."""
    return [
        error
        for k, named in hits(row)
        for error in errors_of(row["truth"]["effects"][k]["parameters"], named["parameters"])
    ]


def counted(row: dict[str, Any]) -> dict[str, list[bool]]:
    """Of what is counted, how each went."""
    true, named, found = len(row["truth"]["effects"]), len(row["answer"]["effects"]), len(hits(row))
    called = [row["withheld"]["verdict"] in ("partial", "unexplained")] if "withheld" in row else []
    return {
        "causes that are named": [k < found for k in range(true)],
        "names that are causes": [k < found for k in range(named)],
        "sizes in their intervals": [abs(error) <= 1 for error in size_errors(row)],
        "shares within 5 points": [abs(error) <= CLOSE for error in share_errors(row)] if true else [],
        "remainder called, a cause withheld": called,
        "all causes and no other": [found == true == named],
    }


def table(rows: Sequence[dict[str, Any]]) -> str:
    """By number of causes, and machine by machine, as Markdown."""
    by = {number: [counted(r) for r in rows if len(r["truth"]["effects"]) == number] for number in COUNTS}
    lines = ["| causes | " + " | ".join(map(str, COUNTS)) + " | all (95 %) |", "|---" * (len(COUNTS) + 2) + "|"]
    for name in next(iter(filter(None, by.values())))[0]:
        each = [[one for row in by[number] for one in row[name]] for number in COUNTS]
        whole = [one for some in each for one in some]
        low, high = wilson(sum(whole), len(whole))
        cells = [f"{sum(some)} of {len(some)}" if some else "-" for some in (*each, whole)]
        lines.append(f"| {name} | {' | '.join(cells)}{f' ({low:.0%} to {high:.0%})' if whole else ''} |")
    cpu = [[r["cpu_s"] for r in rows if len(r["truth"]["effects"]) == number] for number in COUNTS]
    lines.append(f"| CPU s, median | {' | '.join(f'{np.median(c):.0f}' if c else '-' for c in cpu)} | |")
    lines += ["", "| machine | truth | verdict | answer | leaves | without the first |", "|---" * 6 + "|"]
    for row in sorted(rows, key=lambda r: r["number"]):
        said = row["answer"]
        true, named = (", ".join(map(in_words, e)) or "none" for e in (row["truth"]["effects"], said["effects"]))
        left = f"{said['gap']['holdout']['before']:.2f} to {said['gap']['holdout']['after']:.3f}"
        without = row.get("withheld", {}).get("verdict", "-")
        lines.append(f"| {row['number']} | {true} | {said['verdict']} | {named} | {left} | {without} |")
    return "\n".join(lines)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--commit", required=True, help="that is tried")
    parser.add_argument("--machines", type=int, default=60)
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--keep", type=Path, default=Path("budgets.jsonl"))
    options = parser.parse_args()
    drawn = tasks(options.machines, entropy_of(options.commit, "budgets"))
    rows = all_rows(tried, drawn, options.keep, options.jobs)
    print(table(rows))
    some = [task for task in drawn if task.ids and task.number % WITHHELD == 1]
    without = all_rows(tried_without, some, options.keep.with_suffix(".withheld.jsonl"), options.jobs)
    print(table(with_withheld(rows, without)))
    return 0


if __name__ == "__main__":
    sys.exit(main())
